"""An implement driven through the bed: what is told to it, and what is recorded."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from synth.dem.bed import Bed, contact_law
from synth.dem.contact_law import largest_time_step
from synth.dem.grains import Grains
from synth.dem.solver import Solver
from synth.dem.tool import Tool
from synth.implements import RigidWheel
from synth.recording import Recording
from synth.scene import SoilBinScene


@dataclass(frozen=True)
class Schedule:
    """How time is cut; simulated time runs `speed_up` times as fast as the laboratory's.

    Attributes
    ----------
    interval : float
        Laboratory time between two records of force, s.
    steps : int
        Time steps an interval.
    time_step : float
        Simulated, s.
    run_in : int
        Intervals before the first frame.
    recorded : int
        Intervals from the first to the last frame.
    """

    interval: float
    steps: int
    time_step: float
    run_in: int
    recorded: int

    @classmethod
    def of(cls, scene: SoilBinScene, largest_step: float) -> "Schedule":
        """The scene's schedule, with whole steps between records."""
        timing = scene.timing
        interval = 1 / (timing.frame_rate * timing.samples_per_frame)
        simulated = interval / timing.speed_up
        steps = int(np.ceil(simulated / largest_step))
        return cls(
            interval=interval,
            steps=steps,
            time_step=simulated / steps,
            run_in=int(np.ceil(-scene.program.time[0] / interval - 1e-9)),
            recorded=(timing.frame_count - 1) * timing.samples_per_frame,
        )


def run_implement(
    scene: SoilBinScene, bed: Bed, *, progress: Callable[[int, int], None] | None = None
) -> Recording:
    """Drive the scene's implement through the bed.

    It touches down on the levelled bed; the drive's program prescribes travel and rotation. A wheel's axle
    rises and sinks freely under the dead load, which is a force and not a mass, so that driving faster than
    the laboratory adds no inertia.
    """
    law = contact_law(scene)
    largest = largest_time_step(bed.grains.mass, law.normal_stiffness, scene.contact.steps_per_contact)
    schedule = Schedule.of(scene, largest)
    surface = surface_height(bed.grains, scene.bed.grain_diameter)
    tool = _touching_down(scene, bed.grains)
    solver = Solver(bed.grains, law, scene.bed.width, schedule.time_step, tool=tool)
    log = _Log(scene, schedule, tool, surface)
    if schedule.run_in == 0:
        log.frame(solver)
    total = schedule.run_in + schedule.recorded
    for interval in range(total):
        _drive(solver, scene, (interval - schedule.run_in + 0.5) * schedule.interval)
        solver.advance(schedule.steps)
        log.sample(interval, solver)
        since_first = interval + 1 - schedule.run_in
        if since_first >= 0 and since_first % scene.timing.samples_per_frame == 0:
            log.frame(solver)
        if progress is not None:
            progress(interval + 1, total)
    return log.recording({"surface_height": surface, "solid_fraction": bed.solid_fraction})


def surface_height(grains: Grains, grain_diameter: float) -> float:
    """Mean height of the topmost grains' tops over columns two diameters wide, m."""
    column = np.floor(grains.position[0] / (2 * grain_diameter)).astype(int)
    tops = np.zeros(column.max() + 1)
    np.maximum.at(tops, column, grains.position[1] + grains.radius)
    return float(tops[tops > 0].mean())


def _touching_down(scene: SoilBinScene, grains: Grains) -> Tool:
    """The implement just above the grains: as low as it can be without touching one."""
    implement, start = scene.implement, scene.drive.start
    shape = implement.shape
    below = np.abs(grains.position[0] - start) < shape.reach + grains.radius
    position, radius = grains.position[:, below].T, grains.radius[below]

    def clear(z: float) -> bool:
        return bool((shape.distance_to_capsules(position - (start, z)) > radius[:, None]).all())

    low, high = 0.0, scene.bed.depth + shape.reach + scene.bed.grain_diameter
    while high - low > 1e-3 * scene.bed.grain_diameter:
        middle = (low + high) / 2
        low, high = (low, middle) if clear(middle) else (middle, high)
    mass = implement.moving_mass / implement.width if isinstance(implement, RigidWheel) else 1.0
    return Tool(shape=shape, x=start, z=high, mass=mass, heaves=scene.program.heaves)


def _drive(solver: Solver, scene: SoilBinScene, time: float) -> None:
    """Tell the implement what the program wants at a time of the laboratory."""
    implement, fast = scene.implement, scene.timing.speed_up
    velocity_x, velocity_z, spin, load = scene.program.at(time)
    full_load = implement.normal_load / implement.width if isinstance(implement, RigidWheel) else 0.0
    solver.drive_tool(
        velocity_x=fast * velocity_x, velocity_z=fast * velocity_z, spin=fast * spin, load=load * full_load
    )


def slip_of(velocity: float, rim_speed: float) -> float:
    """Driving slip 1 - v / (r omega) for r omega >= v, else skid r omega / v - 1 (-1: locked); at rest 0.

    Parameters
    ----------
    velocity, rim_speed : float
        Of axle and rim, in the same unit, positive where they lead towards the same side.
    """
    if velocity < 0 or (velocity == 0 and rim_speed < 0):
        velocity, rim_speed = -velocity, -rim_speed
    if rim_speed >= velocity:
        return 1 - velocity / rim_speed if rim_speed > 0 else 0.0
    return rim_speed / velocity - 1


class _Log:
    """Collects records of force and frames, in the laboratory's time and for the wheel's width."""

    def __init__(self, scene: SoilBinScene, schedule: Schedule, tool: Tool, surface: float) -> None:
        self._scene, self._schedule = scene, schedule
        self._start_x, self._surface = tool.x, surface
        self._samples: list[tuple[float, ...]] = []
        self._frames: list[tuple[Tool, Grains]] = []
        self._overlaps: list[np.ndarray] = []

    def sample(self, interval: int, solver: Solver) -> None:
        """Record forces, averaged over the interval that has just ended."""
        schedule, implement = self._schedule, self._scene.implement
        impulse, tool = solver.take_tool_impulse(), solver.read_tool()
        radius = implement.radius if isinstance(implement, RigidWheel) else 0.0
        share = implement.width / (schedule.steps * schedule.time_step)
        self._samples.append(
            (
                (interval + 1 - schedule.run_in) * schedule.interval,
                tool.x - self._start_x,
                slip_of(tool.velocity_x, -tool.spin * radius),
                self._surface - tool.lowest,
                impulse.x * share,
                impulse.z * share,
                impulse.moment * share,
            )
        )

    def frame(self, solver: Solver) -> None:
        """Record the states of grains and implement."""
        self._frames.append((solver.read_tool(), solver.read_grains()))
        self._overlaps.append(solver.overlaps())

    def recording(self, attributes: dict[str, float]) -> Recording:
        """Everything collected, as a recording."""
        overlap = np.concatenate(self._overlaps)
        soundness = {
            "overlap_mean": float(overlap.mean()),
            "overlap_p99": float(np.quantile(overlap, 0.99)),
            "overlap_max": float(overlap.max()),
        }
        arrays = {**self._frame_arrays(), **self._sample_arrays()}
        hashes = {"simulation_hash": self._scene.simulation_hash}
        return Recording.from_arrays(arrays, {**hashes, **attributes, **soundness})

    def _frame_arrays(self) -> dict[str, np.ndarray]:
        tools, grains = zip(*self._frames, strict=True)
        slow = 1 / self._scene.timing.speed_up
        x = np.array([tool.x for tool in tools])
        return {
            "time": np.arange(len(tools)) / self._scene.timing.frame_rate,
            "carriage_x": x,
            "implement_x": x.copy(),
            "implement_z": np.array([tool.z for tool in tools]),
            "implement_angle": np.array([tool.angle for tool in tools]),
            "radius": grains[0].radius,
            "position_x": np.stack([state.position[0] for state in grains]),
            "position_z": np.stack([state.position[1] for state in grains]),
            "angle": np.stack([state.angle for state in grains]),
            "velocity_x": np.stack([state.velocity[0] for state in grains]) * slow,
            "velocity_z": np.stack([state.velocity[1] for state in grains]) * slow,
        }

    def _sample_arrays(self) -> dict[str, np.ndarray]:
        names = ("sample_time", "travel", "slip", "sinkage", "force_x", "force_z", "torque")
        columns = np.array(self._samples, dtype=np.float64).reshape(-1, len(names)).T
        return dict(zip(names, columns, strict=True))
