"""What a run records: forces at the end of every interval, states at every frame."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from synth.dem.contacts import Contacts
from synth.dem.grains import Grains, Spheres
from synth.dem.rim import rim_state
from synth.dem.solver import Solver
from synth.dem.tool import Tool
from synth.implements import RigidWheel
from synth.recording import RIM_COLUMNS, Recording
from synth.scene import SoilBinScene

_SAMPLE = ("sample_time", "travel", "slip", "sinkage", "force_x", "force_z", "torque")


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

    @property
    def total(self) -> int:
        """Intervals in all."""
        return self.run_in + self.recorded

    def time_at(self, intervals: float) -> float:
        """Laboratory time after so many intervals, s; 0 at the first frame."""
        return (intervals - self.run_in) * self.interval


@dataclass(frozen=True)
class Frame:
    """The states of implement and grains at one moment, in simulated time; contacts where wanted."""

    tool: Tool
    grains: Grains
    contacts: Contacts | None = None

    def to_arrays(self) -> dict[str, np.ndarray]:
        """What `of_arrays` makes the same frame from, given any other frame of the run."""
        tool, grains = self.tool, self.grains
        pose = [tool.x, tool.z, tool.angle, tool.velocity_x, tool.velocity_z, tool.spin, tool.load]
        arrays = {
            "tool": np.array(pose),
            "position": grains.position,
            "velocity": grains.velocity,
            "angle": grains.angle,
            "spin": grains.spin,
        }
        if tool.nodes is not None and tool.node_velocity is not None:
            arrays |= {"nodes": tool.nodes, "node_velocity": tool.node_velocity}
        if self.contacts is not None:
            arrays |= {f"contact_{name}": array for name, array in vars(self.contacts).items()}
        return arrays

    @classmethod
    def of_arrays(cls, arrays: dict[str, np.ndarray], tool: Tool, grains: Grains) -> "Frame":
        """A frame of the run that `tool` and `grains` belong to."""
        names = ("x", "z", "angle", "velocity_x", "velocity_z", "spin", "load")
        pose = dict(zip(names, arrays["tool"].tolist(), strict=True))
        moved = replace(
            grains,
            position=arrays["position"],
            velocity=arrays["velocity"],
            angle=arrays["angle"],
            spin=arrays["spin"],
        )
        rim = replace(tool, nodes=arrays.get("nodes"), node_velocity=arrays.get("node_velocity"))
        contacts = None
        if "contact_pairs" in arrays:
            contacts = Contacts(*(arrays[f"contact_{name}"] for name in ("pairs", "normal", "tangential")))
        return cls(replace(rim, **pose), moved, contacts)


class RunLog:
    """Collects records of force and frames, in the laboratory's time and for the implement's width.

    Attributes
    ----------
    frames : list of Frame
    samples : list of tuple of float
        Columns as in a recording: sample_time, travel, slip, sinkage, force_x, force_z, torque; of a wheel
        with an elastic rim also deflection, contact_length, rolling_radius.
    greatest_overlap : float
        Of two grains at the end of an interval / their mean diameter.
    """

    def __init__(
        self, scene: SoilBinScene, schedule: Schedule, tool: Tool, grains: Grains, surface: float
    ) -> None:
        self._scene, self._schedule, self._surface = scene, schedule, surface
        self._tool, self._grains = tool, grains
        self._columns = _SAMPLE if tool.ring is None else (*_SAMPLE, *RIM_COLUMNS)
        self.samples: list[tuple[float, ...]] = []
        self.frames: list[Frame] = []
        self.greatest_overlap = 0.0

    def sample(self, interval: int, solver: Solver) -> None:
        """Record forces, averaged over the interval that has just ended."""
        schedule, implement = self._schedule, self._scene.implement
        impulse, tool = solver.take_tool_impulse(), solver.read_tool()
        radius = implement.radius if isinstance(implement, RigidWheel) else 0.0
        width = implement.width / self._scene.simulated_width
        share = width / (schedule.steps * schedule.time_step)
        self.samples.append(
            (
                schedule.time_at(interval + 1),
                tool.x - self._tool.x,
                slip_of(tool.velocity_x, -tool.spin * radius),
                self._surface - tool.lowest,
                impulse.x * share,
                impulse.z * share,
                impulse.moment * share,
                *self._of_rim(tool, solver),
            )
        )

    def _of_rim(self, tool: Tool, solver: Solver) -> tuple[float, ...]:
        """Deflection, contact length and rolling radius now; nothing of a rigid implement."""
        if tool.ring is None:
            return ()
        state = rim_state(tool, solver.read_grains())
        return state.deflection, state.contact_length, state.rolling_radius

    def frame(self, solver: Solver) -> None:
        """Record the states of grains and implement, and the forces between grains if the scene wants."""
        contacts = solver.pair_forces() if self._scene.timing.record_contacts else None
        self.frames.append(Frame(solver.read_tool(), solver.read_grains(), contacts))

    def restore(self, samples: np.ndarray, frames: list[dict[str, np.ndarray]], overlap: float) -> None:
        """Take up what a run had collected: samples (S, columns), frames as `Frame.to_arrays` gave them."""
        self.samples = [tuple(row) for row in samples.tolist()]
        self.frames = [Frame.of_arrays(frame, self._tool, self._grains) for frame in frames]
        self.greatest_overlap = overlap

    def recording(self, attributes: Mapping[str, float | str]) -> Recording:
        """Everything collected, as a recording."""
        hashes = {"simulation_hash": self._scene.simulation_hash}
        arrays = {
            **self._frame_arrays(),
            **self._slab_arrays(),
            **self._rim_arrays(),
            **self._contact_arrays(),
            **self.sample_arrays(),
        }
        return Recording.from_arrays(arrays, {**hashes, **attributes})

    def sample_arrays(self) -> dict[str, np.ndarray]:
        """Records of force by name, each of shape (S,)."""
        columns = np.array(self.samples, dtype=np.float64).reshape(-1, len(self._columns)).T
        return dict(zip(self._columns, columns, strict=True))

    def _rim_arrays(self) -> dict[str, np.ndarray]:
        """Where the nodes of an elastic rim are at every frame; nothing of a rigid implement."""
        ring = self._tool.ring
        if ring is None:
            return {}
        nodes = np.array([frame.tool.nodes for frame in self.frames], float)
        nodes = nodes.reshape(len(self.frames), ring.node_count, 2)
        return {"rim_x": nodes[:, :, 0].copy(), "rim_z": nodes[:, :, 1].copy()}

    def _contact_arrays(self) -> dict[str, np.ndarray]:
        """Forces between grains of all frames, one after the other; nothing where none are recorded."""
        if not self._scene.timing.record_contacts:
            return {}
        contacts = [frame.contacts or Contacts.none() for frame in self.frames] or [Contacts.none()]
        return {
            "contact_count": np.array([one.normal.size for one in contacts[: len(self.frames)]], np.int64),
            "contact_first": np.concatenate([one.pairs[0] for one in contacts]),
            "contact_second": np.concatenate([one.pairs[1] for one in contacts]),
            "contact_normal_force": np.concatenate([one.normal for one in contacts]),
            "contact_tangential_force": np.concatenate([one.tangential for one in contacts]),
        }

    def _frame_arrays(self) -> dict[str, np.ndarray]:
        slow = 1 / self._scene.timing.speed_up
        shape = (len(self.frames), self._grains.count)
        poses = np.array([(f.tool.x, f.tool.z, f.tool.angle) for f in self.frames], float).reshape(-1, 3)
        rows = (shape[0], len(self._grains.position), shape[1])
        position = np.array([frame.grains.position for frame in self.frames]).reshape(rows)
        velocity = np.array([frame.grains.velocity for frame in self.frames]).reshape(rows) * slow
        return {
            "time": np.arange(len(self.frames)) / self._scene.timing.frame_rate,
            "carriage_x": poses[:, 0],
            "implement_x": poses[:, 0].copy(),
            "implement_z": poses[:, 1],
            "implement_angle": poses[:, 2],
            "radius": self._grains.radius,
            "position_x": position[:, 0],
            "position_z": position[:, -1],
            "angle": np.array([frame.grains.angle for frame in self.frames]).reshape(shape),
            "velocity_x": velocity[:, 0],
            "velocity_z": velocity[:, -1],
        }

    def _slab_arrays(self) -> dict[str, np.ndarray]:
        """What spheres have besides: their way across the slab; nothing for discs."""
        if not isinstance(self._grains, Spheres):
            return {}
        shape = (len(self.frames), self._grains.count)
        slow = 1 / self._scene.timing.speed_up
        return {
            "position_y": np.array([frame.grains.position[1] for frame in self.frames]).reshape(shape),
            "velocity_y": np.array([frame.grains.velocity[1] for frame in self.frames]).reshape(shape) * slow,
        }


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
