"""An elastic rim: a ring of nodes on an elastic foundation, and how it stands on a flat floor.

The ring on an elastic foundation with large displacements, as used for tyres (Mousseau, Clark, *Tire
Science and Technology* 22(3), 1994): every node hangs on the hub by a radial and a tangential spring, which
turn with it; neighbours are joined by a bar, and every two bars by an elastic hinge. All is per metre of
width.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_FLOOR = 1e5
"""Stiffness of the floor under a node / that of the node's springs, where a ring's rest is computed."""
_MOST_ITERATIONS = 200
_AT_REST = 1e-6
"""Largest force left over on a node / load, at rest."""
_MOST_TRIALS = 30
_LOAD_MET = 1e-3
"""How far from one load / load asked for may be."""
_LAST, _OWN, _NEXT = -1, 0, 1
"""The nodes that a residual depends on, from the node that it belongs to."""
_Block = tuple[np.ndarray, dict[int, np.ndarray]]
"""A residual of every node (N,), and its derivatives (N, 2) by the nodes it depends on."""


class RingError(ValueError):
    """A ring that cannot be had; the message names the key, the value and what is allowed."""


@dataclass(frozen=True)
class Ring:
    """Constants of an elastic rim, per metre of width.

    Attributes
    ----------
    node_count : int
    node_radius : float
        Of the circle that the nodes are on while nothing acts, m.
    half_thickness : float
        From the nodes' line to the surface that soil touches, m.
    node_mass : float
        kg/m.
    radial_stiffness, tangential_stiffness : float
        Of a node's springs to the hub, N/m per metre.
    damping : float
        Of a node's dashpots to the turning hub, in any direction, N s/m per metre.
    hoop_stiffness : float
        Of a bar between two neighbours, N/m per metre.
    bending_stiffness : float
        Of a hinge, N m per metre and rad.
    """

    node_count: int
    node_radius: float
    half_thickness: float
    node_mass: float
    radial_stiffness: float
    tangential_stiffness: float
    damping: float
    hoop_stiffness: float
    bending_stiffness: float

    @property
    def angles(self) -> np.ndarray:
        """The nodes on the circle, counter-clockwise from +x of the hub's frame, rad, shape (N,)."""
        return 2 * np.pi * np.arange(self.node_count) / self.node_count

    @property
    def unloaded(self) -> np.ndarray:
        """The nodes while nothing acts, in the hub's frame, m, shape (N, 2)."""
        return self.node_radius * np.stack([np.cos(self.angles), np.sin(self.angles)], axis=1)

    @property
    def bar_length(self) -> float:
        """Length of a bar while nothing acts, m."""
        return 2 * self.node_radius * float(np.sin(np.pi / self.node_count))

    @property
    def hinge_angle(self) -> float:
        """Turn from one bar to the next while nothing acts, rad."""
        return 2 * np.pi / self.node_count

    def largest_time_step(self, contact_stiffness: float) -> float:
        """Time step that follows the fastest motion of a node, s: half of what would be unstable.

        The symplectic Euler rule is stable below 2 / omega. Gershgorin's circles bound omega by the row sums
        of the stiffness matrix: 4 bars, 16 hinges, the springs to the hub, and what touches the node.

        Parameters
        ----------
        contact_stiffness : float
            Of all the contacts that one node can have, N/m per metre.
        """
        hinge = 16 * self.bending_stiffness / self.bar_length**2
        hub = max(self.radial_stiffness, self.tangential_stiffness)
        square = (4 * self.hoop_stiffness + hinge + hub + contact_stiffness) / self.node_mass
        damped = self.damping / self.node_mass
        # (omega dt)^2 + rate dt <= 1, where 4 and 2 would be the limits
        return float(2 / (damped + np.sqrt(damped**2 + 4 * square)))


@dataclass(frozen=True, eq=False)
class FloorRest:
    """A ring at rest on a flat floor without friction.

    Attributes
    ----------
    nodes : ndarray, shape (N, 2)
        From the axle, m.
    load : float
        That presses the axle down, N/m.
    """

    nodes: np.ndarray
    load: float


def rest_on_floor(ring: Ring, deflection: float, *, start: np.ndarray | None = None) -> FloorRest:
    """A ring whose axle has come `deflection` (m) nearer to a flat floor than the unloaded outer radius.

    Parameters
    ----------
    start : ndarray, shape (N, 2), optional
        A guess of the nodes.

    Raises
    ------
    RingError
        No rest is found.
    """
    problem = _FloorProblem(ring, deflection)
    nodes = ring.unloaded if start is None else start
    floor = max(problem.lowest_node, -ring.node_radius)
    nodes = np.stack([nodes[:, 0], np.maximum(nodes[:, 1], floor)], axis=1)
    for _ in range(_MOST_ITERATIONS):
        residual, jacobian = problem.linearized(nodes)
        force = jacobian.T @ residual
        load = problem.load(nodes)
        if np.abs(force).max() <= _AT_REST * max(load, ring.radial_stiffness * deflection * 1e-3):
            return FloorRest(nodes, load)
        nodes = problem.improved(nodes, residual, jacobian, force)
    raise RingError(f"deflection = {deflection:g} m: no state of rest found on a flat floor: take it smaller")


class _FloorProblem:
    """The energy of a ring over a floor, as half the sum of squares of residuals."""

    def __init__(self, ring: Ring, deflection: float) -> None:
        self._ring = ring
        self.lowest_node = deflection - ring.node_radius
        self._floor = _FLOOR * (ring.radial_stiffness + ring.tangential_stiffness)
        self._nodes = np.arange(ring.node_count)
        self._places = {shift: np.roll(self._nodes, -shift) for shift in (_LAST, _OWN, _NEXT)}

    def load(self, nodes: np.ndarray) -> float:
        """What the floor carries, N/m."""
        return float(self._floor * np.maximum(self.lowest_node - nodes[:, 1], 0).sum())

    def linearized(self, nodes: np.ndarray) -> tuple[np.ndarray, "csr_array"]:
        """Residuals (5 N,) and their derivatives by the nodes' coordinates, sparse (5 N, 2 N)."""
        from scipy.sparse import csr_array

        blocks = (*self._hub(nodes), self._bars(nodes), self._hinges(nodes), self._touch(nodes))
        residual = np.concatenate([values for values, _ in blocks])
        rows, columns, entries = [], [], []
        for block, (_, by_nodes) in enumerate(blocks):
            for node, derivative in by_nodes.items():
                rows.append(np.repeat(block * len(nodes) + self._nodes, 2))
                columns.append((2 * self._places[node][:, None] + (0, 1)).ravel())
                entries.append(derivative.ravel())
        places = np.concatenate(rows), np.concatenate(columns)
        return residual, csr_array((np.concatenate(entries), places), shape=(residual.size, nodes.size))

    def improved(
        self, nodes: np.ndarray, residual: np.ndarray, jacobian: "csr_array", force: np.ndarray
    ) -> np.ndarray:
        """A Gauss-Newton step, shortened until the energy falls."""
        from scipy.sparse.linalg import spsolve

        step = -spsolve((jacobian.T @ jacobian).tocsc(), force).reshape(-1, 2)
        energy, share = residual @ residual, 1.0
        while share > 1e-6:
            ahead = self.residual(nodes + share * step)
            if ahead @ ahead < energy:
                break
            share /= 2
        return nodes + share * step

    def residual(self, nodes: np.ndarray) -> np.ndarray:
        """Residuals alone."""
        blocks = (*self._hub(nodes), self._bars(nodes), self._hinges(nodes), self._touch(nodes))
        return np.concatenate([values for values, _ in blocks])

    def _hub(self, nodes: np.ndarray) -> list[_Block]:
        ring = self._ring
        outwards = ring.unloaded / ring.node_radius
        along = np.stack([-outwards[:, 1], outwards[:, 0]], axis=1)
        moved = nodes - ring.unloaded
        radial, tangential = np.sqrt(ring.radial_stiffness), np.sqrt(ring.tangential_stiffness)
        return [
            (radial * (moved * outwards).sum(axis=1), {_OWN: radial * outwards}),
            (tangential * (moved * along).sum(axis=1), {_OWN: tangential * along}),
        ]

    def _bars(self, nodes: np.ndarray) -> _Block:
        length, along, _ = self._edges(nodes)
        weight = np.sqrt(self._ring.hoop_stiffness)
        by_nodes = {_OWN: -weight * along, _NEXT: weight * along}
        return weight * (length - self._ring.bar_length), by_nodes

    def _hinges(self, nodes: np.ndarray) -> _Block:
        length, along, across = self._edges(nodes)
        before = np.roll(along, 1, axis=0)
        turn = np.arctan2(
            before[:, 0] * along[:, 1] - before[:, 1] * along[:, 0], (before * along).sum(axis=1)
        )
        weight = np.sqrt(self._ring.bending_stiffness)
        after = weight * across / length[:, None]
        earlier = np.roll(after, 1, axis=0)
        by_nodes = {_LAST: earlier, _OWN: -after - earlier, _NEXT: after}
        return weight * (turn - self._ring.hinge_angle), by_nodes

    def _touch(self, nodes: np.ndarray) -> _Block:
        depth = np.maximum(self.lowest_node - nodes[:, 1], 0)
        weight = np.sqrt(self._floor)
        downwards = np.stack([np.zeros_like(depth), np.where(depth > 0, -weight, 0.0)], axis=1)
        return weight * depth, {_OWN: downwards}

    def _edges(self, nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Length of every bar, its direction, and that turned counter-clockwise by a quarter."""
        bar = np.roll(nodes, -1, axis=0) - nodes
        length = np.hypot(*bar.T)
        along = bar / length[:, None]
        return length, along, np.stack([-along[:, 1], along[:, 0]], axis=1)


def stiffened(ring: Ring, deflection: float, load: float) -> Ring:
    """The ring with hub springs, their ratio kept, under which a `load` (N/m) makes the `deflection` (m).

    Raises
    ------
    RingError
        None is found.
    """
    scale, nodes = load / (deflection * ring.node_radius), None
    ratio = ring.tangential_stiffness / ring.radial_stiffness
    length = ring.bar_length
    for _ in range(_MOST_TRIALS):
        ring = replace(ring, radial_stiffness=scale * length, tangential_stiffness=ratio * scale * length)
        rest = rest_on_floor(ring, deflection, start=nodes)
        if abs(rest.load / load - 1) < _LOAD_MET:
            return ring
        nodes = rest.nodes
        scale *= load / rest.load
    raise RingError(
        f"deflection = {deflection:g} m: no foundation found that gives way so far under {load:g} N/m: "
        "take deflection or bending_stiffness lower"
    )
