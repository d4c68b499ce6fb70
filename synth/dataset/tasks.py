"""What a worker does: settle a bed, simulate a motion, take a member's pictures.

Tasks depend on each other and give no data to each other: what they make is in the cache and in the data
set's folder. A task that finds its result there has nothing to do.
"""

import functools
import json
import logging
import os
import shutil
import socket
import threading
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from synth.dataset.folder import CHECKPOINT, FACTS_FILE, SWEEP_FILE, DataSetFolder
from synth.dataset.members import NAME_LENGTH, Failure
from synth.dataset.versions import decisive_versions, differing
from synth.dem.failures import SimulationError
from synth.disk import system_complaint, written_whole
from synth.scene import AnalyticScene, AnyScene, SoilBinScene

SCENE_FILE = "scene.toml"
_log = logging.getLogger(__name__)
_one_at_a_time = threading.Lock()
"""taichi's kernels are not for several threads at once, whatever a user's own cluster is set up for."""


@dataclass(frozen=True)
class Order:
    """What all tasks of a sweep are told.

    Attributes
    ----------
    folder : DataSetFolder
        With an absolute path, that workers see as well.
    device : {"cpu", "cuda"}
    versions : dict of str
        `decisive_versions` of who ordered.
    """

    folder: DataSetFolder
    device: str
    versions: dict[str, str]


class StageError(RuntimeError):
    """A task went wrong by no fault of its scene: a disk, a device; `args` are stage and reason."""


Seconds = dict[str, float]
"""What each stage took; that of a stage whose result was there before is missing."""
Result = Failure | Seconds


def _task(stage: str) -> Callable[[Callable[..., bool]], Callable[..., Result]]:
    """Make a task of a function that says whether there was something to do.

    It waits for the result of the stage before, which may be a failure. What is wrong with a scene is a
    result; anything else that goes wrong (a disk, a device) is raised and tried once more.
    """

    def decorate(work: Callable[..., bool]) -> Callable[..., Result]:
        @functools.wraps(work)
        def task(order: Order, scene: AnyScene, before: Result | None = None) -> Result:
            if isinstance(before, Failure):
                return before
            spent = dict(before or {})
            try:
                with _one_at_a_time:
                    _check_worker(order)
                    started = time.perf_counter()
                    done = work(order, scene, spent)
                    took = time.perf_counter() - started
            except (ValueError, SimulationError) as error:
                return Failure(stage, in_one_line(error))
            except Exception as error:
                raise StageError(stage, in_one_line(error)) from error
            return {**spent, stage: took} if done else spent

        return task

    return decorate


@_task("bed")
def settle(order: Order, scene: SoilBinScene, _: Seconds) -> bool:
    """Settle a scene's bed into the cache of the worker's machine."""
    from synth.dem.bed import settled_bed

    _start(order, scene)
    settled_bed(scene)
    return True


@_task("simulation")
def simulate(order: Order, scene: AnyScene, _: Seconds) -> bool:
    """Simulate a motion, from its checkpoint where there is one: recordings/SIMULATION.nc."""
    import synth

    simulation = scene.simulation_hash[:NAME_LENGTH]
    final = order.folder.recording(simulation)
    with order.folder.making(simulation) as place:
        if final.is_file():
            return False
        _start(order, scene)
        try:
            recording = synth.simulate(
                scene, device=order.device, threads=1, checkpoint=place / CHECKPOINT, say=_log.info
            )
        except SimulationError:
            shutil.rmtree(place)  # going on from its checkpoint would only stop there again
            raise
        recording.data.attrs["digest"] = recording.digest
        with written_whole(final, draft=place / final.name) as draft:
            recording.write(draft)
        shutil.rmtree(place)
        return True


@_task("pictures")
def photograph(order: Order, scene: AnyScene, spent: Seconds) -> bool:
    """Take a member's pictures, read them back, and publish its folder: sequences/NAME."""
    name = scene.hash[:NAME_LENGTH]
    final = order.folder.sequence(name)
    with order.folder.making(name) as place:
        if order.folder.is_made(name):
            return False
        _start(order, scene)
        draft = place / name
        shutil.rmtree(draft, ignore_errors=True)  # of one that was killed
        try:
            _write_sequence(order, scene, draft, spent)
            final.parent.mkdir(exist_ok=True)
            draft.rename(final)
        finally:
            shutil.rmtree(place)
        return True


def _write_sequence(order: Order, scene: AnyScene, draft: Path, spent: Seconds) -> None:
    import synth
    from synth.checksums import write_checksums
    from synth.dataset.facts import sequence_facts

    started, simulation = time.perf_counter(), scene.simulation_hash[:NAME_LENGTH]
    with synth.Recording.open(order.folder.recording(simulation)) as recording:
        recording_digest = recording.data.attrs["digest"]
        with synth.render(recording, scene, draft, device=order.device, threads=1) as footage:
            facts = sequence_facts(footage)
    (draft / SCENE_FILE).write_text(scene.to_toml(), encoding="utf-8")
    facts |= {
        "schema_version": 1,
        "simulation": simulation,
        "recording_digest": recording_digest,
        "seconds": {**spent, "pictures": time.perf_counter() - started},
        "bytes": sum(path.stat().st_size for path in draft.rglob("*") if path.is_file()),
        "versions": order.versions,
    }
    (draft / FACTS_FILE).write_text(json.dumps(facts, indent=1) + "\n", encoding="utf-8")
    write_checksums(draft)


def _start(order: Order, scene: AnyScene) -> None:
    """One thread a worker, as many members as cores are made at once; and nothing said by each of them."""
    import cv2

    from synth.devices import start_taichi

    cv2.setNumThreads(1)
    if not isinstance(scene, AnalyticScene):  # that has no kernels
        os.environ["ENABLE_TAICHI_HEADER_PRINT"] = "0"
        warnings.filterwarnings("ignore", message="You are unrolling more than", category=SyntaxWarning)
        start_taichi(order.device, 1)


def _check_worker(order: Order) -> None:
    """Refuse to work where it would not be of the same kind, or would not be found.

    Raises
    ------
    ValueError
        Other versions, or a file system that is not shared.
    """
    if not (order.folder.path / SWEEP_FILE).is_file():
        raise ValueError(
            f"worker on {socket.gethostname()}: {order.folder.path} is not seen there: a shared file system "
            "is needed"
        )
    other = differing(order.versions, decisive_versions())
    if other is not None:
        raise ValueError(f"worker on {socket.gethostname()} (process {os.getpid()}): {other}")


def in_one_line(error: BaseException) -> str:
    """What an error says."""
    if (complaint := system_complaint(error)) is not None:
        return complaint
    if isinstance(error, ValueError | SimulationError):
        return " ".join(str(error).split())
    return " ".join(f"{type(error).__name__}: {error}".split())
