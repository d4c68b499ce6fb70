"""Scene -> Recording: the one way in, whatever the scene."""

from collections.abc import Callable

import numpy as np

from synth.devices import start_taichi
from synth.recording import Recording
from synth.scene import PlateScene, Scene, SoilBinScene

Progress = Callable[[int, int], None]

_BED_SHARE = 0.4
"""Share of a simulation's time that the bed takes, roughly: for the progress shown, for nothing else."""
_PARTS = 1000


def simulate(
    scene: Scene, *, device: str = "cpu", threads: int | None = None, progress: Progress | None = None
) -> Recording:
    """Run a scene's experiment.

    Parameters
    ----------
    scene : Scene
    device : {"cpu", "cuda"}
    threads : int, optional
        Default: every core. The recording does not depend on it.
    progress : callable, optional
        Called with (parts done, parts in all).

    Raises
    ------
    synth.dem.solver.SimulationError
        The simulation cannot go on.
    """
    if isinstance(scene, PlateScene):
        return _turn_plate(scene)
    return _work_soil(scene, device, threads, progress)


def _work_soil(scene: SoilBinScene, device: str, threads: int | None, progress: Progress | None) -> Recording:
    start_taichi(device, threads)
    from synth.dem.bed import settled_bed
    from synth.dem.run import run_implement

    bed = settled_bed(scene, progress=_share(progress, 0.0, _BED_SHARE))
    return run_implement(scene, bed, progress=_share(progress, _BED_SHARE, 1.0))


def _turn_plate(scene: PlateScene) -> Recording:
    """A plate carries its soil rigidly: there is no grain to simulate, only the plate's angle."""
    frame_count, pin = scene.timing.frame_count, scene.implement
    frames, nothing = np.zeros(frame_count), np.zeros(0)
    no_grains = np.zeros((frame_count, 0))
    arrays = {
        "time": np.arange(frame_count) / scene.timing.frame_rate,
        "carriage_x": frames,
        "implement_x": frames + pin.pin_x,
        "implement_z": frames + pin.pin_z,
        "implement_angle": np.arange(frame_count) * pin.rotation,
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
