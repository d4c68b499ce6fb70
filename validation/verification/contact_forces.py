"""Forces of all contacts at an instant, computed anew from what the solver's state is.

Written from the contact law and not from the kernels, so that it can be held against them.
"""

from dataclasses import dataclass

import numpy as np

from synth.dem.contact_law import ContactLaw, contact_damping
from synth.dem.grains import Grains
from synth.dem.solver import Solver

FLOOR, LEFT, RIGHT = range(3)
_INTO_WALL = np.array([[0.0, -1.0], [-1.0, 0.0], [1.0, 0.0]])


@dataclass(frozen=True)
class ContactForces:
    """Forces at an instant, N per metre of width.

    Attributes
    ----------
    pairs : ndarray, shape (2, P)
        Grains that touch.
    on_first : ndarray, shape (2, P)
        Force (x, z) on the first of each pair.
    from_walls : ndarray, shape (3, 2, N)
        Force (x, z) of floor, left and right wall on every grain.
    """

    pairs: np.ndarray
    on_first: np.ndarray
    from_walls: np.ndarray

    def upward_through(self, heights: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Upward force of the grains below each height on those above, N/m, shape of `heights`."""
        lower, upper = np.sort(z[self.pairs], axis=0)
        first_is_upper = z[self.pairs[0]] > z[self.pairs[1]]
        upward = np.where(first_is_upper, 1.0, -1.0) * self.on_first[1]
        crosses = (lower < heights[:, None]) & (heights[:, None] <= upper)
        return (crosses * upward).sum(axis=1)


def contact_forces(solver: Solver) -> ContactForces:
    """Forces between grains and of walls on grains, in the solver's present state."""
    state, grains = solver.save_state(), solver.read_grains()
    pairs, on_first = _pair_forces(solver, grains, state["pairs"], state["pair_memory"])
    from_walls = _wall_forces(solver, grains, state["wall_memory"])
    return ContactForces(pairs, on_first, from_walls)


def _pair_forces(
    solver: Solver, grains: Grains, pairs: np.ndarray, memory: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs that touch (2, P), and the force on the first of each (2, P)."""
    law = _linear(solver)
    branch = grains.position[:, pairs[1]] - grains.position[:, pairs[0]]
    distance = np.hypot(*branch)
    overlap = grains.radius[pairs].sum(axis=0) - distance
    touching = overlap > 0
    pairs, overlap, spring = pairs[:, touching], overlap[touching], memory[: touching.size][touching, 0]
    i, j = pairs
    normal = branch[:, touching] / distance[touching]
    arm = grains.radius[pairs] - overlap / 2
    velocity = grains.velocity[:, i] - grains.velocity[:, j]
    rim = grains.spin[i] * arm[0] + grains.spin[j] * arm[1]
    damping = _damping(solver, grains.mass[i] * grains.mass[j] / (grains.mass[i] + grains.mass[j]))
    return pairs, _force(law, normal, overlap, velocity, rim, damping, law.friction, spring)


def _wall_forces(solver: Solver, grains: Grains, memory: np.ndarray) -> np.ndarray:
    """Force of every wall on every grain, shape (3, 2, N)."""
    law, width, damping = _linear(solver), solver.width, _damping(solver, grains.mass)
    (x, z), radius = grains.position, grains.radius
    overlaps = np.stack([radius - z, radius - x, x + radius - width])
    forces = np.zeros((3, 2, grains.count))
    for wall, overlap in enumerate(overlaps):
        normal = np.repeat(_INTO_WALL[wall][:, None], grains.count, axis=1)
        rim = grains.spin * (radius - overlap / 2)
        spring = memory[:, 2 * wall]
        force = _force(law, normal, overlap, grains.velocity, rim, damping, law.wall_friction, spring)
        forces[wall] = np.where(overlap > 0, force, 0.0)
    return forces


def _linear(solver: Solver) -> ContactLaw:
    assert isinstance(solver.law, ContactLaw)
    return solver.law


def _damping(solver: Solver, mass: np.ndarray) -> np.ndarray:
    """Dashpot constant / root of stiffness, of contacts with a reduced mass (kg/m), shape (K,)."""
    return contact_damping(solver.law, mass, np.ones(mass.size), solver.time_step)


def _force(
    law: ContactLaw,
    normal: np.ndarray,
    overlap: np.ndarray,
    velocity: np.ndarray,
    rim: np.ndarray,
    damping: np.ndarray,
    friction: float,
    spring: np.ndarray,
) -> np.ndarray:
    """Force on the grain that `normal` points away from, shape (2, K)."""
    approach = velocity[0] * normal[0] + velocity[1] * normal[1]
    sliding = velocity[1] * normal[0] - velocity[0] * normal[1] + rim
    dashpots = damping * np.sqrt(np.array([[law.normal_stiffness], [law.tangential_stiffness]]))
    pressing = np.maximum(0, law.normal_stiffness * overlap + dashpots[0] * approach)
    limit = friction * pressing
    along = np.clip(spring - dashpots[1] * sliding, -limit, limit)
    return np.stack([-pressing * normal[0] - along * normal[1], -pressing * normal[1] + along * normal[0]])
