"""A suite carried out: in parallel over processes, going on where it was stopped, failures told."""

import os
import shutil
import tempfile
import traceback
from collections.abc import Callable, Iterator
from concurrent.futures import Future, as_completed
from dataclasses import dataclass
from functools import cache
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

from synth.disk import written_whole
from validation.processes import worker_processes
from validation.run_folder import PARTIAL_PREFIX, RunFolder
from validation.suites.measurement_file import key_in, write_measurement
from validation.suites.plan import Look, Motion, Realisation, Suite
from validation.terminal import Terminal, error_line
from validation.versions import package_version

if TYPE_CHECKING:
    import numpy as np

    from synth import Footage, Recording
    from synth.scene import AnyScene
    from validation.scoring.truth_pass import TruePair

MOTIONS = "motions"
"""Folder below a suite's: a run folder for each simulation, shared by all suites that write there."""
MEASURED = "measured"
"""Folder with one netCDF file for each realisation and method."""
KEPT = ".flow"
"""Folder with the flow of measurements that are being made: killed, they go on pair by pair."""
_MADE_BY = ("softbed", "numpy", "scipy", "taichi", "opencv-python-headless", "scikit-learn")


@dataclass(frozen=True)
class Task:
    """All that is to be done about one motion, by one process.

    Attributes
    ----------
    out : Path
        The suite's folder.
    motion : Motion
    looks : tuple of Look
        Those at one realisation follow each other.
    threads : int
        Of this process.
    """

    out: Path
    motion: Motion
    looks: tuple[Look, ...]
    threads: int = 1


@dataclass(frozen=True)
class Failure:
    """What could not be done.

    Attributes
    ----------
    name : str
        Of a motion, a realisation or a look.
    reason : str
        One line.
    """

    name: str
    reason: str


def carry_out(suite: Suite, out: Path, *, processes: int | None = None, terminal: Terminal) -> list[Failure]:
    """Measure what is missing of a suite.

    Each motion is one task: simulated (a checkpoint lets it go on where it was killed), its pictures taken
    and looked at. A measurement is a file that appears when it is whole; those that are there, made by the
    same versions from the same scene, are not made again.

    Parameters
    ----------
    out : Path
        The suite's folder; several suites may share it, and the simulations in it.
    processes : int, optional
        Default: one a core.

    Returns
    -------
    list of Failure
        Empty if all is done. What failed does not keep the others from being done.

    Raises
    ------
    RunFolderError
        The folder holds something else, or another process works in it.
    """
    with RunFolder.create(out):  # nobody else works in it, and what a killed suite left half-written is gone
        (out / MEASURED).mkdir(exist_ok=True)
        tasks = list(_missing(suite, out))
        total = sum(len(task.looks) for task in tasks)
        terminal.say(f"suite {suite.name}: {total} of {len(suite.looks)} measurements are missing")
        if not tasks:
            return []
        count = min(processes or os.cpu_count() or 1, len(tasks))
        with terminal.progress(f"suite {suite.name}, {count} processes") as progress:
            return _in_parallel(tasks, count, progress)


def _in_parallel(tasks: list[Task], processes: int, progress: Callable[[int, int], None]) -> list[Failure]:
    with worker_processes(processes) as pool:
        return _collected({pool.submit(carry_out_task, task): task for task in tasks}, progress)


def _collected(
    futures: dict[Future[list[Failure]], Task], progress: Callable[[int, int], None]
) -> list[Failure]:
    failures: list[Failure] = []
    done, total = 0, sum(len(task.looks) for task in futures.values())
    progress(0, total)
    for future in as_completed(futures):
        task = futures[future]
        try:
            failures += future.result()
        except Exception as error:  # a process that was killed
            failures.append(Failure(task.motion.name, _in_one_line(error)))
        done += len(task.looks)
        progress(done, total)
    return failures


def _missing(suite: Suite, out: Path) -> Iterator[Task]:
    by_motion: dict[Motion, list[Look]] = {}
    for look in suite.looks:
        if not is_measured(out, look):
            by_motion.setdefault(look.realisation.motion, []).append(look)
    for motion, looks in by_motion.items():
        yield Task(out, motion, tuple(looks))


def carry_out_task(task: Task) -> list[Failure]:
    """Simulate a motion, where that was not done, and measure all that is asked for; in its own process."""
    terminal = Terminal(prefix=f"{task.motion.name}: ")
    try:
        recording = _recording(task, terminal)
    except Exception as error:
        return [Failure(task.motion.name, _in_one_line(error))]
    failures = []
    for realisation, looks in groupby(task.looks, key=lambda look: look.realisation):
        failures += _measure_all(task, recording, realisation, list(looks), terminal)
    return failures


def _recording(task: Task, terminal: Terminal) -> "Recording":
    import synth
    from validation import chain

    with RunFolder.create(task.out / MOTIONS / task.motion.name) as run:
        work = chain.Work("cpu", task.threads)
        chain.simulate(run, task.motion.load(), work=work, terminal=terminal, overwrite=True)
        return synth.Recording.read(run.recording)


def _measure_all(
    task: Task,
    recording: "Recording",
    realisation: Realisation,
    looks: list[Look],
    terminal: Terminal,
) -> list[Failure]:
    """Take the pictures once, and let every method look at them."""
    from validation.suites.measurement import photograph, remembered_truth

    failures = []
    with tempfile.TemporaryDirectory(dir=task.out, prefix=PARTIAL_PREFIX) as scratch:
        try:
            footage = photograph(recording, realisation, Path(scratch) / "footage", threads=task.threads)
        except Exception as error:
            return [Failure(realisation.name, _in_one_line(error))]
        with footage:
            truth = remembered_truth(footage)
            for look in looks:
                try:
                    _measure_one(task, footage, truth, look, Path(scratch))
                    told = f"{realisation.severity} pictures {realisation.picture_seed}"
                    terminal.say(f"{told}: measured by {look.method}")
                except Exception as error:
                    failures.append(Failure(look.name, _in_one_line(error)))
    return failures


def _measure_one(
    task: Task, footage: "Footage", truth: Callable[[int], "TruePair"], look: Look, scratch: Path
) -> None:
    from validation.suites.measurement import SCHEMA_VERSION, measure

    realisation = look.realisation
    scene = realisation.scene()
    kept = task.out / KEPT / look.name
    found = measure(
        footage,
        look.method,
        truth=truth,
        pair_count=look.pair_count,
        periods=_periods(scene),
        further=look.further,
        scratch=scratch,
        threads=task.threads,
        keep=kept,
    )
    found = found.assign_attrs(
        schema_version=SCHEMA_VERSION,
        key=_key(look),
        realisation=realisation.name,
        scene=realisation.motion.scene,
        motion=realisation.motion.name,
        soil=getattr(getattr(scene, "soil", None), "name", ""),
        seed=realisation.motion.seed,
        picture_seed=realisation.picture_seed,
        severity=realisation.severity,
        stride=realisation.stride,
        label=realisation.label,
        quick=int(realisation.motion.quick),
        scene_hash=scene.hash,
        threads=task.threads,
    )
    with written_whole(measured_file(task.out, look), draft=scratch / "measured.nc") as draft:
        write_measurement(found, draft)
    shutil.rmtree(kept, ignore_errors=True)


def _periods(scene: "AnyScene") -> "np.ndarray | None":
    """Period of an alternating strain in each column, px; None for scenes without."""
    import numpy as np

    from synth.analytic.motion import SinusoidalStrain
    from synth.scene import AnalyticScene

    if not (isinstance(scene, AnalyticScene) and isinstance(scene.motion, SinusoidalStrain)):
        return None
    return scene.motion.period(np.arange(scene.camera.width) - (scene.camera.width - 1) / 2)


def measured_file(out: Path, look: Look) -> Path:
    """Where a measurement is kept."""
    return out / MEASURED / f"{look.name}.nc"


def is_measured(out: Path, look: Look) -> bool:
    """Whether a measurement is there, made by these versions from this scene."""
    return key_in(measured_file(out, look)) == _key(look)


def _key(look: Look) -> str:
    return look.key(_made_by())


@cache
def _made_by() -> dict[str, str]:
    return {name: package_version(name) for name in _MADE_BY}


def _in_one_line(error: BaseException) -> str:
    text = error_line(error)
    if isinstance(error, ValueError | OSError):
        return text
    place = traceback.extract_tb(error.__traceback__)
    return f"{type(error).__name__}: {text}" + (f" ({place[-1].name})" if place else "")
