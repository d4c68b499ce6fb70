"""A wheel driven through the bed: what is told to it, and what is recorded."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from synth.dem.bed import Bed, contact_law
from synth.dem.contact_law import largest_time_step
from synth.dem.grains import Grains
from synth.dem.solver import Solver, Tool
from synth.implements import RigidWheel
from synth.recording import Recording
from synth.scene import SoilBinScene

_RAMP_SHARE = 0.2
"""Share of the run-in over which load and speed grow from nothing: a soft touch-down."""


@dataclass(frozen=True)
class Schedule:
    """When what happens, in simulated time, which runs `speed_up` times as fast as the laboratory's.

    Attributes
    ----------
    ramp : float
        Time over which load and speed grow from nothing, s.
    interval : float
        Time between two records of force, s.
    steps : int
        Time steps an interval.
    run_in : int
        Intervals before the first frame.
    recorded : int
        Intervals from the first to the last frame.
    """

    ramp: float
    interval: float
    steps: int
    run_in: int
    recorded: int

    @classmethod
    def of(cls, scene: SoilBinScene, largest_step: float) -> "Schedule":
        """The scene's schedule, with whole steps between records."""
        wheel, timing = scene.implement, scene.timing
        speed = wheel.carriage_speed * timing.speed_up
        ramp = 2 * _RAMP_SHARE * wheel.run_in / speed
        interval = 1 / (timing.frame_rate * timing.samples_per_frame * timing.speed_up)
        run_in = (wheel.run_in / speed + ramp / 2) / interval
        return cls(
            ramp=ramp,
            interval=interval,
            steps=int(np.ceil(interval / largest_step)),
            run_in=int(np.ceil(run_in - 1e-9)),
            recorded=(timing.frame_count - 1) * timing.samples_per_frame,
        )

    @property
    def time_step(self) -> float:
        """Time step of the integration, s."""
        return self.interval / self.steps

    def strength(self, interval: int) -> float:
        """Share of full load and speed in the middle of an interval."""
        return min(1.0, (interval + 0.5) * self.interval / self.ramp) if self.ramp > 0 else 1.0


def run_wheel(
    scene: SoilBinScene, bed: Bed, *, progress: Callable[[int, int], None] | None = None
) -> Recording:
    """Drive the scene's wheel through the bed.

    The wheel touches down on the levelled bed; load and speed grow softly over the first part of the run-in,
    at the scene's slip throughout. The carriage prescribes travel and rotation; the axle rises and sinks
    freely under the dead load, which is a force and not a mass, so that driving faster than the laboratory
    adds no inertia.
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
        _drive(solver, scene, schedule.strength(interval))
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
    """The wheel just above the grains: as low as it can be without touching one."""
    wheel = scene.implement
    x, z = grains.position
    below = np.abs(x - wheel.start) < wheel.radius
    reach = wheel.radius + grains.radius[below]
    axle_z = np.max(z[below] + np.sqrt(np.maximum(reach**2 - (x[below] - wheel.start) ** 2, 0)))
    return Tool(
        x=wheel.start,
        z=float(axle_z),
        radius=wheel.radius,
        mass=wheel.moving_mass / wheel.width,
        load=0.0,
    )


def _drive(solver: Solver, scene: SoilBinScene, strength: float) -> None:
    wheel: RigidWheel = scene.implement
    speed = strength * scene.timing.speed_up
    solver.drive_tool(
        velocity_x=speed * wheel.carriage_speed,
        spin=speed * wheel.angular_velocity,
        load=strength * wheel.normal_load / wheel.width,
    )


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
        schedule, wheel = self._schedule, self._scene.implement
        impulse, tool = solver.take_tool_impulse(), solver.read_tool()
        lab_interval = schedule.interval * self._scene.timing.speed_up
        self._samples.append(
            (
                (interval + 1 - schedule.run_in) * lab_interval,
                tool.x - self._start_x,
                wheel.slip,
                self._surface - (tool.z - tool.radius),
                impulse.x / schedule.interval * wheel.width,
                impulse.z / schedule.interval * wheel.width,
                impulse.moment / schedule.interval * wheel.width,
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
