"""An implement driven through the bed: what is told to it, and when it is stopped."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from synth.dem.bed import Bed, contact_law
from synth.dem.contact_law import time_step_of
from synth.dem.failures import SimulationError, check
from synth.dem.grains import Grains
from synth.dem.log import RunLog, Schedule
from synth.dem.solver import Solver
from synth.dem.soundness import soundness_of
from synth.dem.tool import Tool
from synth.implements import CompliantWheel, RigidWheel
from synth.recording import Recording
from synth.scene import SoilBinScene

if TYPE_CHECKING:
    from synth.dem.checkpoint import Checkpoint

Progress = Callable[[int, int], None]


def run_implement(
    scene: SoilBinScene, bed: Bed, *, checkpoint: "Checkpoint | None" = None, progress: Progress | None = None
) -> Recording:
    """Drive the scene's implement through the bed.

    It touches down on the levelled bed; the drive's program prescribes travel and rotation. A wheel's axle
    rises and sinks freely under the dead load, which is a force and not a mass, so that driving faster than
    the laboratory adds no inertia.

    Parameters
    ----------
    checkpoint : Checkpoint, optional
        Taken up if there is one, and written now and then; the recording does not depend on it.

    Raises
    ------
    SimulationError
        The state makes no sense any more; its `recording` is what was recorded until then.
    """
    law = contact_law(scene)
    largest = time_step_of(bed.grains, law, scene.contact.steps_per_contact)
    schedule = Schedule.of(scene, largest)
    surface = surface_height(_finest(scene, bed.grains), scene.bed.grain_diameter)
    tool = _touching_down(scene, bed.grains)
    gravity = (0.0, -scene.bed.gravity)
    solver = Solver(
        bed.grains,
        law,
        scene.bed.width,
        schedule.time_step,
        gravity=gravity,
        tool=tool,
        thickness=scene.bed.thickness or np.inf,
    )
    log = RunLog(scene, schedule, tool, bed.grains, surface)
    about_bed = {"surface_height": surface, **_packing(scene, bed)}
    try:
        _record(scene, schedule, solver, log, tool, checkpoint, progress)
    except SimulationError as error:
        time = schedule.time_at(solver.time / (schedule.steps * schedule.time_step))
        stopped = error.at(f"stopped at t = {time:.4g} s in the laboratory")
        stopped.recording = log.recording({**about_bed, "stopped": str(stopped)})
        raise stopped from None
    return log.recording(about_bed | soundness_of(scene, schedule.time_step, log))


def _record(
    scene: SoilBinScene,
    schedule: Schedule,
    solver: Solver,
    log: RunLog,
    start: Tool,
    checkpoint: "Checkpoint | None",
    progress: Progress | None,
) -> None:
    """Advance interval by interval, from the checkpoint on if there is one."""
    done = 0 if checkpoint is None else checkpoint.resume(solver, log)
    if done == 0 and schedule.run_in == 0:
        log.frame(solver)
    for interval in range(done, schedule.total):
        _drive(solver, scene, schedule.time_at(interval + 0.5))
        solver.advance(schedule.steps)
        log.greatest_overlap = max(log.greatest_overlap, check(solver, scene, start))
        log.sample(interval, solver)
        since_first = interval + 1 - schedule.run_in
        if since_first >= 0 and since_first % scene.timing.samples_per_frame == 0:
            log.frame(solver)
        if checkpoint is not None:
            checkpoint.write_if_due(interval + 1, solver, log)
        if progress is not None:
            progress(interval + 1, schedule.total)


def _packing(scene: SoilBinScene, bed: Bed) -> dict[str, float]:
    """How densely the bed is packed, and how far that is from what the scene wants."""
    about = {"solid_fraction": bed.solid_fraction}
    if bed.relative_density is not None:
        about["relative_density"] = bed.relative_density
        if scene.bed.relative_density is not None:
            about["relative_density_deviation"] = abs(bed.relative_density - scene.bed.relative_density)
    return about


def _finest(scene: SoilBinScene, grains: Grains) -> Grains:
    """The grains where the implement works: all, but of a graded bed."""
    fine = scene.bed.fine
    if scene.bed.coarsening == 1 or fine is None:
        return grains
    return grains.only((grains.in_plane[0] >= fine.left) & (grains.in_plane[0] <= fine.right))


def surface_height(grains: Grains, grain_diameter: float) -> float:
    """Mean height of the topmost grains' tops over columns two diameters wide, m."""
    x, z = grains.in_plane
    column = np.floor((x - x.min()) / (2 * grain_diameter)).astype(int)
    tops = np.zeros(column.max() + 1)
    np.maximum.at(tops, column, z + grains.radius)
    return float(tops[tops > 0].mean())


def _touching_down(scene: SoilBinScene, grains: Grains) -> Tool:
    """The implement just above the grains: as low as it can be without touching one."""
    implement, start = scene.implement, scene.drive.start
    shape = implement.shape
    below = np.abs(grains.in_plane[0] - start) < shape.reach + grains.radius
    position, radius = grains.in_plane[:, below].T, grains.radius[below]

    def clear(z: float) -> bool:
        offset = position - (start, z)
        apart = (shape.distance_to_capsules(offset) > radius[:, None]).all()
        return bool(apart and not shape.encloses(offset).any())

    low, high = 0.0, scene.bed.depth + shape.reach + scene.bed.grain_diameter
    while high - low > 1e-3 * scene.bed.grain_diameter:
        middle = (low + high) / 2
        low, high = (low, middle) if clear(middle) else (middle, high)
    share = scene.simulated_width / implement.width
    mass = implement.moving_mass * share if isinstance(implement, RigidWheel) else 1.0
    ring = implement.ring if isinstance(implement, CompliantWheel) else None
    return Tool(shape=shape, x=start, z=high, mass=mass, heaves=scene.program.heaves, ring=ring)


def _drive(solver: Solver, scene: SoilBinScene, time: float) -> None:
    """Tell the implement what the program wants at a time of the laboratory."""
    implement, fast = scene.implement, scene.timing.speed_up
    velocity_x, velocity_z, spin, load = scene.program.at(time)
    share = scene.simulated_width / implement.width
    full_load = implement.normal_load * share if isinstance(implement, RigidWheel) else 0.0
    solver.drive_tool(
        velocity_x=fast * velocity_x, velocity_z=fast * velocity_z, spin=fast * spin, load=load * full_load
    )
