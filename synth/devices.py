"""Where kernels run: one place that starts taichi, quietly and once."""

import contextlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

DEVICES = ("cpu", "cuda")
_LONGEST_UNROLLED = 36
"""Turns of a loop that a kernel writes out; taichi warns of longer ones, which take long to compile.

A group of samples has as many: see `synth.camera.samples`.
"""


def cache_folder() -> Path:
    """Folder for settled beds and compiled kernels: `$SOFTBED_CACHE`, else the platform's user cache."""
    import platformdirs

    chosen = os.environ.get("SOFTBED_CACHE")
    return Path(chosen) if chosen else Path(platformdirs.user_cache_dir("softbed"))


def start_taichi(device: str = "cpu", threads: int | None = None) -> Any:
    """Start taichi unless somebody already has: a second start would destroy existing fields.

    Parameters
    ----------
    device : {"cpu", "cuda"}
        Honoured by the first start in a process only.
    threads : int, optional
        Default: every core. Honoured by the first start only. Results do not depend on it.

    Returns
    -------
    module
        taichi, started.

    Raises
    ------
    ValueError
        Unknown device, or one that is not here.
    """
    if device not in DEVICES:
        raise ValueError(f"device = {device!r}: allowed are {', '.join(DEVICES)}")
    with standard_output_to_error():  # taichi greets there
        import taichi as ti

        if not _started(ti):
            kernels = cache_folder() / "kernels"
            kernels.mkdir(parents=True, exist_ok=True)
            _require_device(ti, device)
            ti.init(
                arch=ti.cuda if device == "cuda" else ti.cpu,
                cpu_max_num_threads=threads or os.cpu_count() or 1,
                default_fp=ti.f64,
                fast_math=False,
                unrolling_limit=_LONGEST_UNROLLED,
                offline_cache=True,
                offline_cache_file_path=str(kernels),
                log_level=ti.ERROR,
                enable_fallback=False,
            )
    return ti


def thread_count() -> int:
    """Threads that kernels run on; every core before taichi was started."""
    with standard_output_to_error():
        import taichi as ti

        chosen = ti.lang.impl.current_cfg().cpu_max_num_threads if _started(ti) else os.cpu_count()
    return int(chosen or 1)


def _require_device(ti: Any, device: str) -> None:
    if device == "cuda" and not ti.lang.misc.is_arch_supported(ti.cuda):
        raise ValueError("device = 'cuda': no CUDA device is found here")


def _started(ti: Any) -> bool:
    return ti.lang.impl.get_runtime().prog is not None


@contextlib.contextmanager
def standard_output_to_error() -> Iterator[None]:
    """Send to standard error what even compiled code prints: standard output belongs to results."""
    sys.stdout.flush()
    kept = os.dup(1)
    try:
        os.dup2(2, 1)
        yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(kept)
