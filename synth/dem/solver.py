"""The solver: grains, walls and one implement, advanced step by step."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from synth.dem.contact_law import ContactLaw
from synth.dem.grains import Grains
from synth.dem.neighbours import NeighbourList, carry_memory, list_neighbours
from synth.scene import GRAVITY

SKIN = 0.3
"""Thickness of the neighbour list's skin / mean grain diameter."""
_REBUILD_AT = 0.4
"""Share of the skin a grain may move before neighbours are listed anew; past half, contacts are missed."""


_MOST_UNWATCHED = 16
"""Launches between two looks at how far grains have moved, at most."""


class SimulationError(RuntimeError):
    """The simulation cannot go on; the message says which grain, when, and what to change."""


@dataclass
class Tool:
    """A disc-shaped implement that travels and turns as told, and rises and sinks under a load.

    Per metre of width. World frame; rotation counter-clockwise positive.
    """

    x: float
    z: float
    radius: float
    mass: float
    load: float
    angle: float = 0.0
    velocity_x: float = 0.0
    velocity_z: float = 0.0
    spin: float = 0.0


@dataclass(frozen=True)
class ToolImpulse:
    """What the grains did to the implement over an interval: integrals over time, per metre of width."""

    x: float
    z: float
    moment: float


@dataclass
class Solver:
    """Grains in a box of given width, open at the top, with a floor at z = 0.

    Parameters
    ----------
    grains : Grains
    law : ContactLaw
    width : float
        Distance between the end walls, m.
    time_step : float
        s.
    gravity : tuple of float
        Acceleration along x and z, m/s2.
    drag : float
        Rate at which motion dies away of itself, 1/s; for settling only.
    tool : Tool, optional
    """

    grains: Grains
    law: ContactLaw
    width: float
    time_step: float
    gravity: tuple[float, float] = (0.0, -GRAVITY)
    drag: float = 0.0
    tool: Tool | None = None
    time: float = field(default=0.0, init=False)

    def __post_init__(self) -> None:
        import taichi as ti

        self._ti: Any = ti
        grains = self.grains
        self._skin = SKIN * 2 * float(grains.radius.mean())
        state = np.concatenate([grains.position, grains.velocity, [grains.angle], [grains.spin]])
        self._motion = self._array(state)
        self._body = self._array(np.stack([grains.radius, grains.mass, grains.inertia]))
        self._boundary_memory = self._array(np.zeros((8, grains.count)))
        self._tool = self._array(self._tool_row())
        self._constants = self._array(self._constants_row())
        self._neighbours: NeighbourList | None = None
        self._pair_memory: Any = None
        self._unwatched, self._watch_after = 0, 1
        self._list_neighbours()

    def advance(self, steps: int) -> None:
        """Take so many time steps.

        Raises
        ------
        SimulationError
            A grain moved so far between two looks that a contact may have been missed.
        """
        from synth.dem.kernels import STEPS_PER_LAUNCH

        whole, rest = divmod(steps, STEPS_PER_LAUNCH)
        for chunk in [STEPS_PER_LAUNCH] * whole + [1] * rest:
            self._launch(chunk)
            self.time += chunk * self.time_step
            self._unwatched += 1
            if self._unwatched >= self._watch_after:
                self._watch()
        self._watch()

    def drive_tool(self, *, velocity_x: float, spin: float, load: float) -> None:
        """Tell the implement how to travel (m/s), how to turn (rad/s), and its load (N/m)."""
        from synth.dem import kernels as k

        for row, value in ((k.TOOL_VX, velocity_x), (k.TOOL_SPIN, spin), (k.TOOL_LOAD, load)):
            self._tool[row] = value

    def read_tool(self) -> Tool:
        """The implement as it is now.

        Raises
        ------
        ValueError
            There is none.
        """
        from synth.dem import kernels as k

        if self.tool is None:
            raise ValueError("this solver has no implement")
        row = self._tool.to_numpy()
        return Tool(
            x=row[k.TOOL_X],
            z=row[k.TOOL_Z],
            radius=row[k.TOOL_RADIUS],
            mass=row[k.TOOL_MASS],
            load=row[k.TOOL_LOAD],
            angle=row[k.TOOL_ANGLE],
            velocity_x=row[k.TOOL_VX],
            velocity_z=row[k.TOOL_VZ],
            spin=row[k.TOOL_SPIN],
        )

    def take_tool_impulse(self) -> ToolImpulse:
        """What the grains did to the implement since this was last asked."""
        from synth.dem import kernels as k

        rows = (k.TOOL_PX, k.TOOL_PZ, k.TOOL_PM)
        impulse = ToolImpulse(*(float(self._tool[row]) for row in rows))
        for row in rows:
            self._tool[row] = 0.0
        return impulse

    def read_grains(self) -> Grains:
        """The grains as they are now."""
        motion = self._motion.to_numpy()
        return Grains(motion[0:2], motion[2:4], motion[4], motion[5], self.grains.radius, self.grains.density)

    def overlaps(self) -> np.ndarray:
        """Overlap / mean grain diameter of every pair in contact, shape (contacts,)."""
        assert self._neighbours is not None
        i, j = self._neighbours.pairs
        position, radius = self._motion.to_numpy()[0:2], self.grains.radius
        overlap = radius[i] + radius[j] - np.hypot(*(position[:, i] - position[:, j]))
        return overlap[overlap > 0] / (2 * radius.mean())

    def _launch(self, steps: int) -> None:
        from synth.dem import kernels as k

        k.advance(
            steps,
            self._constants,
            self.grains.count,
            self._pair_count,
            self._near_count,
            self._motion,
            self._body,
            self._pairs,
            self._pair_body,
            self._pair_memory,
            self._pair_load,
            self._first_contact,
            self._contacts,
            self._boundary_memory,
            self._near_wall,
            self._near_slot,
            self._reaction,
            self._tool,
        )

    def _watch(self) -> None:
        """List neighbours anew in time, and stop where that came too late.

        The next look is due when the fastest grain, at its present speed, moves half of what is left.
        """
        from synth.dem import kernels as k

        if self._unwatched == 0:
            return
        squares = k.greatest_shift_and_speed(self.grains.count, self._motion, self._listed)
        shift, speed = (float(np.sqrt(square)) for square in squares)
        shift = max(shift, self._tool_shift())
        if shift > 0.5 * self._skin:
            raise SimulationError(self._blow_up())
        left = _REBUILD_AT * self._skin - shift
        reach = max(speed * self.time_step * k.STEPS_PER_LAUNCH, 1e-9 * self._skin)
        self._unwatched, self._watch_after = 0, min(_MOST_UNWATCHED, max(1, int(0.5 * left / reach)))
        if left < 0:
            self._list_neighbours()

    def _tool_shift(self) -> float:
        if self.tool is None:
            return 0.0
        tool = self.read_tool()
        return float(np.hypot(tool.x - self._listed_tool.x, tool.z - self._listed_tool.z))

    def _blow_up(self) -> str:
        moved = self._motion.to_numpy()[0:2] - self._listed.to_numpy()
        shift = np.nan_to_num(np.hypot(*moved), nan=np.inf)
        worst = int(shift.argmax())
        return (
            f"grain {worst} moved {shift[worst]:.3g} m in a few steps of {self.time_step:.3g} s at t = "
            f"{self.time:.6g} s (simulated): take contact.steps_per_contact higher, or timing.speed_up lower"
        )

    def _list_neighbours(self) -> None:
        position = self._motion.to_numpy()[0:2]
        listed = list_neighbours(position, self.grains.radius, self._skin)
        self._unwatched, self._watch_after = 0, 1
        memory = np.zeros((2, listed.pairs.shape[1]))
        if self._neighbours is not None:
            memory = carry_memory(self._neighbours, self._pair_memory.to_numpy().T, listed)
        self._neighbours = listed
        self._pair_count = listed.pairs.shape[1]
        capacity = max(self._pair_count, 1)
        self._pairs = self._array(_padded(listed.pairs, capacity))
        self._pair_body = self._array(_padded(_pair_body(self.grains, listed.pairs), capacity).T)
        self._pair_memory = self._array(_padded(memory, capacity).T)
        self._pair_load = self._array(np.zeros((capacity, 4)))
        self._first_contact = self._array(listed.first_contact)
        self._contacts = self._array(_padded(listed.contacts, 2 * capacity))
        self._listed = self._array(position)
        self._list_boundaries(position)

    def _list_boundaries(self, position: np.ndarray) -> None:
        """Which grains may touch a wall or the implement before neighbours are listed anew."""
        reach = self.grains.radius + self._skin
        x, z = position
        near_wall = (z < reach) | (x < reach) | (x > self.width - reach)
        near_tool = np.zeros(0, np.int64)
        if self.tool is not None:
            self._listed_tool = tool = self.read_tool()
            near_tool = np.flatnonzero(np.hypot(x - tool.x, z - tool.z) < reach + tool.radius)
        slot = np.full(self.grains.count, -1, np.int32)
        slot[near_tool] = np.arange(near_tool.size)
        self._near_count = near_tool.size
        self._near_wall = self._array(near_wall.astype(np.int32))
        self._near_slot = self._array(slot)
        self._reaction = self._array(np.zeros((3, max(near_tool.size, 1))))

    def _constants_row(self) -> np.ndarray:
        from synth.dem import kernels as k

        law, row = self.law, np.zeros(k.CONSTANT_COUNT)
        row[[k.KN, k.KT]] = law.normal_stiffness, law.tangential_stiffness
        row[[k.DAMPING_N, k.DAMPING_T]] = 2 * law.damping_ratio * np.sqrt(row[[k.KN, k.KT]])
        row[[k.FRICTION, k.WALL_FRICTION, k.TOOL_FRICTION]] = (
            law.friction,
            law.wall_friction,
            law.implement_friction,
        )
        row[k.ROLLING_FRICTION] = law.rolling_friction
        row[k.ROLLING_STIFFNESS] = 2.25 * law.normal_stiffness * law.rolling_friction**2
        row[k.TIME_STEP] = self.time_step
        row[[k.GRAVITY_X, k.GRAVITY_Z]] = self.gravity
        row[[k.WIDTH, k.DRAG]] = self.width, self.drag
        return row

    def _tool_row(self) -> np.ndarray:
        from synth.dem import kernels as k

        row = np.zeros(k.TOOL_SIZE)
        row[k.TOOL_MASS] = 1.0
        if self.tool is not None:
            tool = self.tool
            row[[k.TOOL_X, k.TOOL_Z, k.TOOL_ANGLE]] = tool.x, tool.z, tool.angle
            row[[k.TOOL_VX, k.TOOL_VZ, k.TOOL_SPIN]] = tool.velocity_x, tool.velocity_z, tool.spin
            row[[k.TOOL_RADIUS, k.TOOL_MASS, k.TOOL_LOAD]] = tool.radius, tool.mass, tool.load
        return row

    def _array(self, values: np.ndarray) -> Any:
        array = self._ti.ndarray(self._ti.i32 if values.dtype == np.int32 else self._ti.f64, values.shape)
        array.from_numpy(np.ascontiguousarray(values))
        return array


def _pair_body(grains: Grains, pairs: np.ndarray) -> np.ndarray:
    """Root of the reduced mass and reduced radius of every pair, shape (2, P)."""
    (mi, mj), (ri, rj) = grains.mass[pairs], grains.radius[pairs]
    return np.stack([np.sqrt(mi * mj / (mi + mj)), ri * rj / (ri + rj)])


def _padded(values: np.ndarray, size: int) -> np.ndarray:
    padded = np.zeros((*values.shape[:-1], size), values.dtype)
    padded[..., : values.shape[-1]] = values
    return padded
