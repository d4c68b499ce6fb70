"""A sweep carried out: what is missing of a data set is made, by whoever the cluster has."""

import hashlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from synth.dataset.cluster import cluster_client, require_distributed
from synth.dataset.folder import BASE_FILE, SWEEP_FILE, DataSetError, DataSetFolder
from synth.dataset.members import Failure, Member, Membership, members_of
from synth.dataset.summary import Told, read_manifest, write_summary
from synth.dataset.sweep import SPLITS, Sweep, load_sweep
from synth.dataset.tasks import Order, Result, StageError, photograph, settle, simulate
from synth.dataset.time_left import TimeLeft
from synth.dataset.versions import DECISIVE, decisive_versions, differing

if TYPE_CHECKING:
    from distributed import Client, Future

    from synth.scene import AnyScene

Progress = Callable[[int, int, float], None]
Task = tuple[str, str]
"""Stage, and name of the bed, the motion or the member."""
_TRIES_AGAIN = 1
"""Of a task that raised something else than a scene's own fault."""


@dataclass(frozen=True)
class Asked:
    """A sweep, read and resolved."""

    sweep: Sweep
    base: "AnyScene"
    membership: Membership

    @classmethod
    def read(cls, path: str | Path) -> "Asked":
        """Read a sweep file; raises what `load_sweep` and `members_of` do."""
        sweep, base = load_sweep(path)
        return cls(sweep, base, members_of(sweep, base))

    @property
    def empty_splits(self) -> list[str]:
        """Splits that are to have a share, and get no member: there are too few simulations."""
        filled = {member.split for member in self.membership.members}
        return [split for split in SPLITS if getattr(self.sweep.split, split) > 0 and split not in filled]


def make_data_set(
    sweep_file: str | Path,
    out: str | Path,
    *,
    scheduler: str | None = None,
    workers: int | None = None,
    device: str = "cpu",
    say: Callable[[str], None] = lambda line: None,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Make all members of a sweep that are not there yet, and write what is to be said of the data set.

    Whatever happens to workers, to this process or to the disk: under its final name nothing is
    half-written, and called again, it does only what is missing.

    Parameters
    ----------
    sweep_file : str or Path
    out : str or Path
        The data set's folder; made where there is none.
    scheduler, workers, device
        As of `cluster_client`.
    say : callable, optional
        Told in one line each where the dashboard is, and what failed.
    progress : callable, optional
        Called with the members done, the members in all, and the seconds left: NaN until each stage that is
        left has shown what it takes.

    Returns
    -------
    dict
        What `manifest.json` holds.

    Raises
    ------
    synth.dataset.sweep.SweepError, synth.scene.SceneError
        The sweep cannot be used.
    DataSetError
        The folder holds something else, another sweep, or what other versions made.
    synth.dataset.cluster.ClusterError
        There is nobody to do it.
    """
    require_distributed()
    asked, folder = Asked.read(sweep_file), DataSetFolder(Path(out).absolute())
    for split in asked.empty_splits:
        say(f"warning: no member in the split {split!r}: simulations are dealt out whole, and are too few")
    with folder.sole_user():
        _adopt(folder, asked)
        members = asked.membership.members
        missing = [member for member in members if not folder.is_made(member.name)]
        folder.clear_work(keep={member.simulation for member in missing})
        failures: dict[str, Failure] = {}
        if missing:
            order = Order(folder, device, decisive_versions())
            with cluster_client(scheduler=scheduler, workers=workers, device=device) as client:
                say(f"dashboard: {client.dashboard_link}")
                _carry_out(client, order, missing, len(members), failures, say, progress)
        manifest = write_summary(folder, Told(asked.sweep, asked.base, asked.membership, failures))
        for split in sorted({member.split for member in members}):
            if not manifest["split_counts"][split]:
                say(f"warning: no member of the split {split!r} could be made: it is empty")
        if not failures:
            folder.remove_work()
    return manifest


def _adopt(folder: DataSetFolder, asked: Asked) -> None:
    """Write the sweep and its scene into the folder, unless what is there is of another one."""
    _refuse_other(folder, asked)
    folder.write(BASE_FILE, asked.base.to_toml())
    folder.write(SWEEP_FILE, asked.sweep.to_toml(scene=BASE_FILE))


def _refuse_other(folder: DataSetFolder, asked: Asked) -> None:
    manifest = read_manifest(folder)
    if manifest is not None:
        other = differing(decisive_versions(), manifest["versions"])
        if other is not None:
            raise DataSetError(
                f"{folder.path}: made with {other}: go on with the same versions of {', '.join(DECISIVE)}, "
                "or choose another folder"
            )
    wanted = {member.name for member in asked.membership.members}
    made = folder.path / "sequences"
    strangers = sorted({path.name for path in made.iterdir()} - wanted) if made.is_dir() else []
    if strangers:
        raise DataSetError(
            f"{folder.path}: holds {len(strangers)} sequences, {strangers[0]} for instance, that are not of "
            f"this sweep: choose another folder, or continue {folder.path / SWEEP_FILE}"
        )


def _carry_out(
    client: "Client",
    order: Order,
    missing: list[Member],
    total: int,
    failures: dict[str, Failure],
    say: Callable[[str], None],
    progress: Progress | None,
) -> None:
    """Let the cluster make what is missing; `failures` is filled by member."""
    done = total - len(missing)
    workers = len(client.nthreads())  # each does one task at a time, whatever threads it has
    with _submitted(client, order, missing) as graph:
        for (stage, name), result in _results(graph.tasks):
            if stage == "pictures":
                done += 1
                if isinstance(result, Failure):
                    failures[name] = result
                    say(f"failed: {name}: {result.stage}: {result.reason}")
            graph.left.finish(stage, name, None if isinstance(result, Failure) else result.get(stage))
            if progress is not None:
                progress(done, total, graph.left.seconds(workers))


@contextmanager
def _submitted(client: "Client", order: Order, missing: list[Member]) -> "Iterator[_Graph]":
    """All tasks submitted, bed by bed and motion by motion; cancelled where this ends early.

    Each bed and each motion is a task once; dask begins with what was submitted first.
    """
    graph = _Graph(client, order)
    ordered = sorted(missing, key=lambda one: (one.bed or "", one.simulation))
    try:
        for member in ordered:
            graph.add(member)
        yield graph
    except BaseException:
        client.cancel(list(graph.tasks))
        raise


class _Graph:
    """Tasks: bed -> simulation -> pictures.

    Attributes
    ----------
    tasks : dict
        Stage and name of each, by its future.
    left : TimeLeft
    """

    def __init__(self, client: "Client", order: Order) -> None:
        self.tasks: dict[Future, Task] = {}
        self.left = TimeLeft()
        self._futures: dict[Task, Future] = {}
        self._client, self._order = client, order
        # A scheduler of the user's own may work on other folders at the same time.
        self._suffix = hashlib.sha256(str(order.folder.path).encode()).hexdigest()[:8]

    def add(self, member: Member) -> None:
        """Submit a member's pictures, and what they need."""
        self._task("pictures", member.name, photograph, member, self._simulation(member))

    def _simulation(self, member: Member) -> "Future":
        there = self._order.folder.recording(member.simulation).is_file()
        before = [] if there or member.bed is None else [self._bed(member, member.bed)]
        return self._task("simulation", member.simulation, simulate, member, *before)

    def _bed(self, member: Member, bed: str) -> "Future":
        return self._task("bed", bed, settle, member)

    def _task(self, stage: str, name: str, work: Any, member: Member, *before: "Future") -> "Future":
        task = (stage, name)
        if task not in self._futures:
            self.left.expect(stage, name, member.scene)
            future = self._client.submit(
                work,
                self._order,
                member.scene,
                *before,
                key=f"{stage}-{name}-{self._suffix}",
                retries=_TRIES_AGAIN,
            )
            self._futures[task], self.tasks[future] = future, task
        return self._futures[task]


def _results(tasks: "dict[Future, Task]") -> Iterator[tuple[Task, Result]]:
    """Results as they come; what was raised is a failure, too."""
    from distributed import as_completed

    for future in as_completed(list(tasks)):
        if future.status == "finished":
            yield tasks[future], future.result()
        elif future.status == "error":
            yield tasks[future], _failure(future.exception())
        else:
            yield tasks[future], Failure("pictures", f"{future.status}: the scheduler went away")


def _failure(error: BaseException | None) -> Failure:
    from distributed import KilledWorker

    if isinstance(error, StageError):
        return Failure(*error.args)
    if isinstance(error, KilledWorker):
        times, last = error.allowed_failures + 1, error.last_worker.address
        reason = f"{times} workers died of it (killed, out of memory?), the last one at {last}"
        return Failure(str(error.task).partition("-")[0], reason)
    return Failure("pictures", " ".join(repr(error).split()))
