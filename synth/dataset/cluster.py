"""Where tasks run: on this machine's cores, or on the user's own cluster; both are dask.distributed's."""

import importlib.util
import logging
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from distributed import Client

HINT = "dask.distributed is not installed: pip install 'softbed[cluster]'"
_DASHBOARD = "127.0.0.1:8787"
"""Where it is looked for; dask takes another port where this one is taken."""
_CONNECT_SECONDS = 30
_PATIENT = {"distributed.deploy.lost-worker-timeout": "1 day"}
"""A worker that died is started again, which takes more than dask's 15 s on a busy machine: then it would be
given up, and once the last one is, a sweep would wait for ever."""


class ClusterError(ValueError):
    """No cluster to work on; the message says why."""


def require_distributed() -> None:
    """Make sure that tasks can be distributed.

    Raises
    ------
    ClusterError
        dask.distributed is not installed; says how to.
    """
    if importlib.util.find_spec("distributed") is None:
        raise ClusterError(HINT)


@contextmanager
def cluster_client(
    *, scheduler: str | None = None, workers: int | None = None, device: str = "cpu"
) -> "Iterator[Client]":
    """Connect to a scheduler, or start workers here: processes of one thread each, which end with this one.

    Parameters
    ----------
    scheduler : str, optional
        Address of the user's own, `tcp://host:8786`; without, a cluster is started here.
    workers : int, optional
        Of the cluster that is started; default: one a core, and on a GPU one.
    device : {"cpu", "cuda"}

    Raises
    ------
    ClusterError
        Nothing answers at the address, or dask.distributed is not installed.
    """
    require_distributed()
    with _connected(scheduler) if scheduler else _local(workers, device) as client:
        yield client


@contextmanager
def _connected(address: str) -> "Iterator[Client]":
    from distributed import Client

    try:
        client = Client(address, timeout=_CONNECT_SECONDS)
    except (OSError, ValueError, TimeoutError) as error:
        raise ClusterError(f"--scheduler {address}: {error}") from None
    with client:
        yield client


@contextmanager
def _local(workers: int | None, device: str) -> "Iterator[Client]":
    import dask
    from dask.system import CPU_COUNT
    from distributed import Client, LocalCluster

    with dask.config.set(_PATIENT), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Port .* is already in use")
        cluster = LocalCluster(
            n_workers=workers or (1 if device == "cuda" else CPU_COUNT),
            threads_per_worker=1,
            processes=True,
            dashboard_address=_DASHBOARD if _has_dashboard() else None,
            silence_logs=logging.CRITICAL,  # what fails is told once, by us
        )
    with dask.config.set(_PATIENT), cluster, Client(cluster) as client:
        yield client
        client.run(_keep_kernels)


def _keep_kernels() -> None:
    """Let a worker write the kernels that it compiled to the cache: at its end it may have no time to."""
    if "taichi" in sys.modules:
        import taichi as ti

        ti.reset()


def _has_dashboard() -> bool:
    return importlib.util.find_spec("bokeh") is not None
