"""Scene -> Recording: the one way in, whatever the scene."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from synth.devices import start_taichi
from synth.recording import Recording
from synth.scene import AnalyticScene, AnyScene, PlateScene, SoilBinScene

if TYPE_CHECKING:
    from synth.dem.bed import Bed
    from synth.dem.checkpoint import Checkpoint

Progress = Callable[[int, int], None]

_BED_SHARE = 0.4
"""Share of a simulation's time that the bed takes, roughly: for the progress shown, for nothing else."""
_PARTS = 1000


def simulate(
    scene: AnyScene,
    *,
    device: str = "cpu",
    threads: int | None = None,
    progress: Progress | None = None,
    checkpoint: Path | None = None,
    say: Callable[[str], None] | None = None,
) -> Recording:
    """Run a scene's experiment.

    Parameters
    ----------
    scene : AnyScene
    device : {"cpu", "cuda"}
    threads : int, optional
        Default: every core. The recording does not depend on it.
    progress : callable, optional
        Called with (parts done, parts in all).
    checkpoint : Path, optional
        Folder to write all of the run's state to every half minute, and to go on from where it is there: of
        the same scene, program version and device. The recording does not depend on it. It is the caller's to
        remove (`synth.dem.checkpoint.remove_checkpoint`) once the recording is safe. A bed that was
        interrupted while it settled is settled anew; a settled one is in the cache.
    say : callable, optional
        Told in one line what was done with a checkpoint that was there.

    Raises
    ------
    synth.dem.failures.SimulationError
        The simulation cannot go on; its `recording` is what was recorded until then, None while the bed
        settled.
    """
    if isinstance(scene, PlateScene):
        return _turn_plate(scene)
    if isinstance(scene, AnalyticScene):
        return _without_grains(scene)
    start_taichi(device, threads)
    bed = _settled(scene, _share(progress, 0.0, _BED_SHARE))
    place = None if checkpoint is None else _checkpoint(checkpoint, scene, bed, device, say)
    from synth.dem.run import run_implement

    return run_implement(scene, bed, checkpoint=place, progress=_share(progress, _BED_SHARE, 1.0))


def _settled(scene: SoilBinScene, progress: Progress | None) -> "Bed":
    from synth.dem.bed import settled_bed
    from synth.dem.failures import SimulationError

    try:
        return settled_bed(scene, progress=progress)
    except SimulationError as error:
        raise error.at("stopped while the bed settled") from None


def _checkpoint(
    folder: Path, scene: SoilBinScene, bed: "Bed", device: str, say: Callable[[str], None] | None
) -> "Checkpoint":
    from synth.dem.checkpoint import Checkpoint, digest_of

    made_from = {
        "scene": scene.simulation_hash,
        "bed": digest_of(bed.grains.position, bed.grains.radius),
        "device": device,
    }
    return Checkpoint(folder, made_from, say=say)


def _turn_plate(scene: PlateScene) -> Recording:
    """A plate carries its soil rigidly: there is no grain to simulate, only the plate's angle."""
    pin = scene.implement
    return _without_grains(scene, pin.pin_x, pin.pin_z, turn=pin.rotation)


def _without_grains(
    scene: PlateScene | AnalyticScene, x: float = 0.0, z: float = 0.0, *, turn: float = 0.0
) -> Recording:
    """Record frame times, and an implement at one place that turns by `turn` (rad) a frame."""
    frame_count = scene.timing.frame_count
    frames, nothing = np.zeros(frame_count), np.zeros(0)
    no_grains = np.zeros((frame_count, 0))
    arrays = {
        "time": np.arange(frame_count) / scene.timing.frame_rate,
        "carriage_x": frames,
        "implement_x": frames + x,
        "implement_z": frames + z,
        "implement_angle": np.arange(frame_count) * turn,
        "radius": nothing,
    }
    grains = ("position_x", "position_z", "angle", "velocity_x", "velocity_z")
    samples = ("sample_time", "travel", "slip", "sinkage", "force_x", "force_z", "torque")
    arrays |= dict.fromkeys(grains, no_grains) | dict.fromkeys(samples, nothing)
    return Recording.from_arrays(arrays, {"simulation_hash": scene.simulation_hash})


def _share(progress: Progress | None, start: float, end: float) -> Progress | None:
    """Progress of a part of the work as progress of the whole."""
    if progress is None:
        return None
    return lambda done, total: progress(round(_PARTS * (start + (end - start) * done / total)), _PARTS)
