"""The solver: grains, walls and one implement, advanced step by step."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from synth.dem.contact_law import Law
from synth.dem.contacts import Contacts
from synth.dem.failures import SimulationError
from synth.dem.grains import Grains, length_of
from synth.dem.layout import body_rows, device_array, layout_of, pair_rows, part_rows, tool_row
from synth.dem.neighbours import Carried, NeighbourList, gap_between, list_neighbours, neighbour_list_of
from synth.dem.rim import rim_rows, ring_row, with_nodes
from synth.dem.sharing import Shares, steps_at_once, worker_count
from synth.dem.tool import Tool, ToolContacts, ToolImpulse, list_tool_contacts
from synth.dem.watch import Watch
from synth.scene import GRAVITY

SKIN = 0.15
"""Thickness of the neighbour list's skin / mean grain diameter; thin, it has few pairs that do not touch."""
_SPARE = 1.1
"""Room of arrays whose length changes / what they have to hold."""
_FINER = "take contact.steps_per_contact higher, or timing.speed_up or the load lower"
_SAVED_ARRAYS = (
    "motion", "listed", "wall_memory", "near_wall", "tool",
    "pair_memory", "contact_load", "tool_memory", "reaction", "ring", "rim", "node_force",
)  # fmt: skip
"""Arrays on the device that cannot be had again from others."""


@dataclass
class Solver:
    """Grains in a box of given width, open at the top, with a floor at z = 0.

    Discs and spheres: what they do is in two files of kernels, `synth.dem.kernels` and
    `synth.dem.sphere_kernels`, with the same entry points and arguments; `synth.dem.layout` says how grains
    and law become the arrays that either reads. All else, lists, memory, watch and states, is here, once.

    Parameters
    ----------
    grains : Grains
        Discs, for which everything is per metre of width; or `Spheres`.
    law : ContactLaw or HertzMindlinLaw
        The latter for spheres only.
    width : float
        Distance between the end walls, m.
    time_step : float
        s.
    gravity : tuple of float
        Acceleration along x and z, m/s2.
    drag : float
        Rate at which motion dies away of itself, 1/s; for settling only.
    tool : Tool, optional
        Among spheres, its mass (kg) and load (N) are those on the whole slab.
    thickness : float
        Of a slab of spheres: distance of the glass, y = 0, from the face opposite, m.
    skin : float
        Thickness of the neighbour list's skin / mean grain diameter. Results do not depend on it.
    """

    grains: Grains
    law: Law
    width: float
    time_step: float
    gravity: tuple[float, float] = (0.0, -GRAVITY)
    drag: float = 0.0
    tool: Tool | None = None
    thickness: float = np.inf
    skin: float = SKIN
    time: float = field(default=0.0, init=False)

    def __post_init__(self) -> None:
        import taichi as ti

        from synth.dem.step_kernels import board_size

        self._ti: Any = ti
        grains = self.grains
        self._layout = layout = layout_of(grains, self.law)
        self._skin = self.skin * 2 * float(grains.radius.mean())
        self._motion = self._array(layout.motion(grains))
        self._body = self._array(body_rows(grains, self.law, self.time_step))
        rows, numbers = layout.wall_memory
        self._wall_memory = self._array(np.zeros((rows * grains.count, numbers)))
        self._tool = self._array(tool_row(self.tool))
        self._parts = self._array(part_rows(self.tool))
        self._constants = self._array(layout.constants(self))
        self._ring = self._array(ring_row(self.tool))
        self._rim = self._array(rim_rows(self.tool))
        self._neighbours: NeighbourList | None = None
        self._listed_tool: Tool | None = None
        self._tool_contacts = ToolContacts.none(grains.count)
        self._listed = self._array(grains.position.T)
        self._near_wall = self._array(np.zeros(grains.count, np.int32))
        self._pairs: Any = None
        self._pair_body: Any = None
        self._pair_memory: Any = None
        self._touched: Any = None
        self._contact_load: Any = None
        self._first_contact: Any = None
        self._near_tool: Any = None
        self._first_tool_contact: Any = None
        self._tool_parts: Any = None
        self._tool_memory = self._array(np.zeros((1, layout.memory)))
        self._reaction: Any = None
        self._node_force: Any = None
        self._workers = worker_count(ti, grains.count)
        self._board = self._array(np.zeros(board_size(self._workers), np.int32))
        self._grain_bounds: Any = None
        self._pair_bounds: Any = None
        self._pair_order: Any = None
        self._watch = Watch(self._skin)
        self._list_neighbours()

    def advance(self, steps: int) -> None:
        """Take so many time steps.

        Raises
        ------
        SimulationError
            A grain moved so far between two looks that a contact may have been missed.
        """
        left = steps
        while left > 0:
            taken = self._launch(min(left, self._watch.left))
            left -= taken
            self.time += taken * self.time_step
            self._watch.unwatched += taken
            if self._watch.left == 0 or left == 0:
                self._look()

    def drive_tool(self, *, velocity_x: float, velocity_z: float, spin: float, load: float) -> None:
        """Tell the implement how to travel (m/s), how to turn (rad/s), and its load (N/m).

        One that rises and sinks under its load is not told `velocity_z`.
        """
        from synth.dem import kernels as k

        told = {k.TOOL_VX: velocity_x, k.TOOL_SPIN: spin, k.TOOL_LOAD: load}
        if self.tool is not None and not self.tool.heaves:
            told[k.TOOL_VZ] = velocity_z
        for row, value in told.items():
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
        tool = self.tool if self.tool.ring is None else with_nodes(self.tool, self._rim.to_numpy())
        return replace(
            tool,
            x=row[k.TOOL_X],
            z=row[k.TOOL_Z],
            angle=row[k.TOOL_ANGLE],
            velocity_x=row[k.TOOL_VX],
            velocity_z=row[k.TOOL_VZ],
            spin=row[k.TOOL_SPIN],
            load=row[k.TOOL_LOAD],
        )

    def take_tool_impulse(self) -> ToolImpulse:
        """What the grains did to the implement since this was last asked."""
        from synth.dem import kernels as k

        rows = (k.TOOL_PX, k.TOOL_PZ, k.TOOL_PM)
        impulse = ToolImpulse(*(float(self._tool[row]) for row in rows))
        for row in rows:
            self._tool[row] = 0.0
        return impulse

    def hub_impulse(self) -> ToolImpulse:
        """What an elastic rim has done to the hub since the start."""
        from synth.dem import rim_kernels as k

        return ToolImpulse(*(float(self._ring[entry]) for entry in (k.HUB_PX, k.HUB_PZ, k.HUB_PM)))

    def read_grains(self) -> Grains:
        """The grains as they are now."""
        return self._layout.grains(self._motion.to_numpy(), self.grains)

    def contacts(self) -> tuple[np.ndarray, np.ndarray]:
        """Pairs of grains in contact, shape (2, contacts), and their overlaps, m, shape (contacts,)."""
        assert self._neighbours is not None
        return self.read_grains().touching(self._neighbours.pairs)

    def pair_forces(self) -> Contacts:
        """The forces between discs in the last time step; none before the first."""
        assert self._neighbours is not None
        pairs = self._neighbours.pairs
        force = self._contact_load.to_numpy()[self._neighbours.ends[0], :2]
        motion = self._motion.to_numpy().T
        # Forces are those of before the step's motion.
        return Contacts.of_forces(motion[0:2] - self.time_step * motion[2:4], pairs, force)

    def save_state(self) -> dict[str, np.ndarray]:
        """All that decides how it goes on, bit by bit: `restore_state` on a new solver takes it up.

        To be asked for between two calls of `advance`.
        """
        assert self._neighbours is not None
        contacts, listed = self._tool_contacts, self._listed_tool
        return {
            "time": np.array(self.time),
            "watch_period": np.array(self._watch.period),
            "listed_tool": np.array([] if listed is None else [listed.x, listed.z, listed.angle]),
            "listed_nodes": np.zeros((0, 2)) if listed is None or listed.nodes is None else listed.nodes,
            "pairs": self._neighbours.pairs,
            "tool_near": contacts.near_tool,
            "tool_first": contacts.first_contact,
            "tool_part": contacts.parts,
            "tool_keys": contacts.keys,
            **{name: getattr(self, f"_{name}").to_numpy() for name in _SAVED_ARRAYS},
        }

    def restore_state(self, state: dict[str, np.ndarray]) -> None:
        """Go on where a solver with the same grains, law and implement stood when it saved its state."""
        self.time = float(state["time"])
        self._watch = Watch(self._skin, int(state["watch_period"]))
        self._neighbours = neighbour_list_of(state["pairs"], self.grains.count)
        self._tool_contacts = ToolContacts(
            *(state[name] for name in ("tool_near", "tool_first", "tool_part", "tool_keys"))
        )
        for name in _SAVED_ARRAYS:
            setattr(self, f"_{name}", self._array(state[name]))
        self._put_lists_on_device()
        if self.tool is not None:
            x, z, angle = state["listed_tool"].tolist()
            nodes = state["listed_nodes"] if self.tool.ring is not None else None
            self._listed_tool = replace(self.read_tool(), x=x, z=z, angle=angle, nodes=nodes)

    def _launch(self, wanted: int) -> int:
        """Take about as many steps as wanted, in one launch; returns how many, never more than wanted."""
        from synth.dem import rim_kernels

        assert self._neighbours is not None
        elastic = self.tool is not None and self.tool.ring is not None
        advance = rim_kernels.advance if elastic else self._layout.kernels.advance
        if self._workers:
            unrolled, steps = 0, min(wanted, steps_at_once(self.grains.count))
            self._board.fill(0)
        else:
            at_once = self._layout.kernels.STEPS_UNROLLED
            unrolled = steps = at_once if wanted >= at_once else 1
        advance(
            unrolled,
            self._layout.features,
            self.grains.count,
            self._neighbours.pairs.shape[1],
            self._workers,
            steps,
            self._grain_bounds,
            self._pair_bounds,
            self._pair_order,
            self._board,
            self._constants,
            self._motion,
            self._body,
            self._pairs,
            self._pair_body,
            self._pair_memory,
            self._touched,
            self._contact_load,
            self._first_contact,
            self._near_wall,
            self._wall_memory,
            self._near_tool,
            self._first_tool_contact,
            self._tool,
            self._parts,
            self._tool_contacts.parts.size,
            self._tool_parts,
            self._tool_memory,
            self._reaction,
            *((self._ring, self._rim, self._node_force) if elastic else ()),
        )
        return steps

    def _look(self) -> None:
        """List neighbours anew in time, and stop where that came too late."""
        squares = self._layout.kernels.greatest_shift_and_speed(self.grains.count, self._motion, self._listed)
        shift, speed = (float(np.sqrt(square)) for square in squares)
        if self._watch.too_far(shift):
            raise SimulationError(self._blow_up(), _FINER)
        tool_shift, tool_speed = self._of_tool()
        if self._watch.too_far(tool_shift):
            raise SimulationError(f"the implement moved {tool_shift:.3g} m in a few time steps", _FINER)
        if self._watch.list_anew(max(shift, tool_shift), max(speed, tool_speed) * self.time_step):
            self._list_neighbours()

    def _of_tool(self) -> tuple[float, float]:
        """How far the implement has moved since its contacts were listed, m, and its greatest speed, m/s."""
        if self.tool is None or self._listed_tool is None:
            return 0.0, 0.0
        tool = self.read_tool()
        speed = float(np.hypot(tool.velocity_x, tool.velocity_z)) + abs(tool.spin) * tool.shape.reach
        if tool.node_velocity is not None:
            speed = max(speed, float(np.hypot(*tool.node_velocity.T).max()))
        return tool.shift_since(self._listed_tool), speed

    def _blow_up(self) -> str:
        listed, grains = self._listed.to_numpy().T, self.read_grains()
        shift = np.nan_to_num(length_of(grains.position - listed), nan=np.inf)
        worst = int(shift.argmax())
        x, z = listed[[0, -1], worst]
        far = f"{shift[worst]:.3g} m" if np.isfinite(shift[worst]) else "beyond any number"
        step = f"{self.time_step:.3g} s"
        return f"grain {worst} moved {far} in a few steps of {step}, from x = {x:.4g} m, z = {z:.4g} m"

    def _list_neighbours(self) -> None:
        position = self._layout.position(self._motion.to_numpy())
        self._listed.from_numpy(np.ascontiguousarray(position.T))
        self._list_pairs(position)
        self._list_tool_contacts(position[[0, -1]])
        self._put_lists_on_device()
        near_wall = self._layout.near_wall(position, self.grains.radius + self._skin, self)
        self._near_wall.from_numpy(near_wall.astype(np.int32))

    def _list_pairs(self, position: np.ndarray) -> None:
        old, new = self._neighbours, list_neighbours(position, self.grains.radius, self._skin)
        count = new.pairs.shape[1]
        memory, load = np.zeros((count, self._layout.memory)), np.zeros((2 * count, self._layout.load))
        if old is not None:
            carried, loads = Carried.between(old.keys, new.keys), self._contact_load.to_numpy()
            memory = carried.carry(self._pair_memory.to_numpy())
            for before, after in zip(old.ends, new.ends, strict=True):
                load[after] = carried.carry(loads[before])
        self._neighbours = new
        self._pair_memory = self._refilled(self._pair_memory, memory)
        self._contact_load = self._refilled(self._contact_load, load)

    def _list_tool_contacts(self, position: np.ndarray) -> None:
        old, new = self._tool_contacts, ToolContacts.none(self.grains.count)
        self._listed_tool = None
        if self.tool is not None:
            self._listed_tool = self.read_tool()
            new = list_tool_contacts(self.grains, position, self._listed_tool, self._skin)
        memory = Carried.between(old.keys, new.keys).carry(self._tool_memory.to_numpy())
        self._tool_contacts = new
        self._tool_memory = self._refilled(self._tool_memory, memory)
        self._reaction = self._refilled(self._reaction, np.zeros((new.keys.size, 3)))
        self._node_force = self._refilled(self._node_force, np.zeros((new.keys.size, 4)))

    def _put_lists_on_device(self) -> None:
        """What follows from the lists of pairs and of contacts with the implement."""
        from synth.dem.step_kernels import CHUNKS

        assert self._neighbours is not None
        pairs, contacts = self._neighbours, self._tool_contacts
        self._pairs = self._refilled(self._pairs, np.concatenate([pairs.pairs, pairs.ends]).T)
        self._touched = self._refilled(self._touched, np.ones(pairs.pairs.shape[1], np.int32))
        self._pair_body = self._refilled(
            self._pair_body, pair_rows(self.grains, self.law, self.time_step, pairs.pairs)
        )
        self._first_contact = self._refilled(self._first_contact, pairs.first_contact)
        gap = gap_between(self._listed.to_numpy().T, self.grains.radius, pairs.pairs)
        shares = Shares.of(pairs, gap < 0, max(1, self._workers) * CHUNKS)
        self._grain_bounds = self._refilled(self._grain_bounds, shares.grain_bounds)
        self._pair_bounds = self._refilled(self._pair_bounds, shares.pair_bounds)
        self._pair_order = self._refilled(self._pair_order, shares.pair_order)
        self._near_tool = self._refilled(self._near_tool, contacts.near_tool)
        self._first_tool_contact = self._refilled(self._first_tool_contact, contacts.first_contact)
        self._tool_parts = self._refilled(self._tool_parts, contacts.parts)

    def _array(self, values: np.ndarray) -> Any:
        """Values (n,), or records (n, k), on the device, in an array of just that length."""
        return device_array(self._ti, values)

    def _refilled(self, array: Any, values: np.ndarray) -> Any:
        """Values in an array that is there, or in a new one where that is too short.

        The device never takes memory back before the process ends, so arrays whose length changes have room
        to spare and are filled again; there are no empty ones. What is beyond the values is zero.
        """
        room = 0 if array is None else array.shape[0]
        if room < len(values) or room == 0:
            room = int(_SPARE * len(values)) + 1
        padded = np.zeros((room, *values.shape[1:]), values.dtype)
        padded[: len(values)] = values
        if array is None or array.shape[0] != room:
            return self._array(padded)
        array.from_numpy(padded)
        return array
