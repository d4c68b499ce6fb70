"""Forces of all contacts at an instant, computed anew from what the solver's state is.

Written from the contact law and not from the kernels, so that it can be held against them; in space, where
discs lie in the plane y = 0 and turn about y.
"""

from dataclasses import dataclass

import numpy as np

from synth.dem.contact_law import ContactLaw, contact_damping
from synth.dem.grains import Grains, Spheres, length_of
from synth.dem.solver import Solver

FLOOR, LEFT, RIGHT, GLASS, BACK = range(5)
"""Walls; discs have the first three."""
X, Y, Z = range(3)
_INTO_WALL = np.array([[0, 0, -1], [-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0]], float)


@dataclass(frozen=True)
class ContactForces:
    """Forces at an instant, N; of discs per metre of width, and without a part along y.

    Attributes
    ----------
    pairs : ndarray, shape (2, P)
        Grains that touch.
    on_first : ndarray, shape (3, P)
        Force (x, y, z) on the first of each pair.
    from_walls : ndarray, shape (3 or 5, 3, N)
        Force (x, y, z) of every wall on every grain.
    """

    pairs: np.ndarray
    on_first: np.ndarray
    from_walls: np.ndarray

    def upward_through(self, heights: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Upward force of the grains below each height on those above, N, shape of `heights`."""
        lower, upper = np.sort(z[self.pairs], axis=0)
        first_is_upper = z[self.pairs[0]] > z[self.pairs[1]]
        upward = np.where(first_is_upper, 1.0, -1.0) * self.on_first[Z]
        crosses = (lower < heights[:, None]) & (heights[:, None] <= upper)
        return (crosses * upward).sum(axis=1)


@dataclass(frozen=True)
class _Bodies:
    """Grains in space: place and velocity (m, m/s), spin (rad/s), each (3, N); radius and mass (N,)."""

    position: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray
    radius: np.ndarray
    mass: np.ndarray

    @classmethod
    def of(cls, grains: Grains) -> "_Bodies":
        if isinstance(grains, Spheres):
            return cls(grains.position, grains.velocity, grains.spin, grains.radius, grains.mass)
        none = np.zeros(grains.count)
        (x, z), (vx, vz) = grains.position, grains.velocity
        spin = np.stack([none, -grains.spin, none])  # counter-clockwise in (x, z) is about -y
        return cls(np.stack([x, none, z]), np.stack([vx, none, vz]), spin, grains.radius, grains.mass)


def contact_forces(solver: Solver) -> ContactForces:
    """Forces between grains and of walls on grains, in the solver's present state."""
    state, bodies = solver.save_state(), _Bodies.of(solver.read_grains())
    pairs, on_first = _pair_forces(solver, bodies, state["pairs"], state["pair_memory"])
    return ContactForces(pairs, on_first, _wall_forces(solver, bodies, state["wall_memory"]))


def _pair_forces(
    solver: Solver, bodies: _Bodies, pairs: np.ndarray, memory: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs that touch (2, P), and the force on the first of each (3, P)."""
    law = _linear(solver)
    branch = bodies.position[:, pairs[1]] - bodies.position[:, pairs[0]]
    distance = length_of(branch)
    overlap = bodies.radius[pairs].sum(axis=0) - distance
    touching = overlap > 0
    pairs, overlap, memory = pairs[:, touching], overlap[touching], memory[: touching.size][touching]
    i, j = pairs
    normal = branch[:, touching] / distance[touching]
    arm = bodies.radius[pairs] - overlap / 2
    rims = np.cross(arm[0] * bodies.spin[:, i] + arm[1] * bodies.spin[:, j], normal, axis=0)
    velocity = bodies.velocity[:, i] - bodies.velocity[:, j] + rims
    damping = _damping(solver, bodies.mass[i] * bodies.mass[j] / (bodies.mass[i] + bodies.mass[j]))
    spring = _springs(solver, memory, normal)
    return pairs, _force(law, normal, overlap, velocity, damping, law.friction, spring)


def _wall_forces(solver: Solver, bodies: _Bodies, memory: np.ndarray) -> np.ndarray:
    """Force of every wall on every grain, shape (walls, 3, N)."""
    law, damping = _linear(solver), _damping(solver, bodies.mass)
    (x, y, z), radius = bodies.position, bodies.radius
    room = [z, x, solver.width - x, y, solver.thickness - y]
    frictions = [*[law.wall_friction] * 3, law.glass_friction, law.back_friction]
    walls = 5 if isinstance(solver.grains, Spheres) else 3
    memory = memory.reshape(radius.size, walls, -1)
    forces = np.zeros((walls, 3, radius.size))
    for wall in range(walls):
        overlap = radius - room[wall]
        arm = radius - np.maximum(overlap, 0) / 2
        normal = np.repeat(_INTO_WALL[wall][:, None], radius.size, axis=1)
        velocity = bodies.velocity + np.cross(arm * bodies.spin, normal, axis=0)
        spring = _springs(solver, memory[:, wall], normal)
        force = _force(law, normal, overlap, velocity, damping, frictions[wall], spring)
        forces[wall] = np.where(overlap > 0, force, 0.0)
    return forces


def _linear(solver: Solver) -> ContactLaw:
    assert isinstance(solver.law, ContactLaw)
    return solver.law


def _damping(solver: Solver, mass: np.ndarray) -> np.ndarray:
    """Dashpot constant / root of stiffness, of contacts with a reduced mass (kg), shape (K,)."""
    return contact_damping(solver.law, mass, np.ones(mass.size), solver.time_step)


def _springs(solver: Solver, memory: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Remembered tangential forces, shape (3, K), in the plane across `normal` (3, K).

    Contacts of discs (K, 2) remember its size along the normal turned counter-clockwise; of spheres (K, 6) a
    vector, which turns with the contact.
    """
    if not isinstance(solver.grains, Spheres):
        return np.asarray(memory[:, 0] * np.stack([-normal[Z], np.zeros(len(memory)), normal[X]]))
    spring = memory[:, :3].T
    flat = spring - (spring * normal).sum(axis=0) * normal
    return _with_length(flat, length_of(spring))


def _with_length(vectors: np.ndarray, length: np.ndarray) -> np.ndarray:
    """Vectors (3, K) of another length (K,); where there is no direction, none."""
    now = length_of(vectors)
    return np.asarray(vectors * np.where(now > 0, length / np.where(now > 0, now, 1.0), 0.0))


def _force(
    law: ContactLaw,
    normal: np.ndarray,
    overlap: np.ndarray,
    velocity: np.ndarray,
    damping: np.ndarray,
    friction: float,
    spring: np.ndarray,
) -> np.ndarray:
    """Force on the grain that `normal` points away from, shape (3, K)."""
    approach = (velocity * normal).sum(axis=0)
    sliding = velocity - approach * normal
    dashpots = damping * np.sqrt(np.array([[law.normal_stiffness], [law.tangential_stiffness]]))
    pressing = np.maximum(0, law.normal_stiffness * overlap + dashpots[0] * approach)
    tangential = spring - dashpots[1] * sliding
    tangential = _with_length(tangential, np.minimum(length_of(tangential), friction * pressing))
    return np.asarray(tangential - pressing * normal)
