"""One collision of two bodies with friction, followed along two lines, without the solver's kernels."""

from dataclasses import dataclass

import numpy as np

from synth.dem.contact_law import HertzMindlinLaw, hertz_time
from synth.dem.damping import HERTZ, damping_constants
from synth.dem.grains import Spheres

_STEPS = 20_000
"""Time steps in a collision: fifty times as many as the solver is given."""


@dataclass(frozen=True)
class Collision:
    """The first of two spheres, or of one and the floor, at the moment they touch.

    Attributes
    ----------
    normal, tangent : ndarray, shape (3,)
        From the first sphere into what it hits; along which its surface slides over it.
    approach, drift : float
        Speeds of the centres along these, m/s.
    turns : ndarray, shape (K,)
        Spin of each sphere that makes its surface slide along the tangent, rad/s.
    masses, radii, inertias : ndarray, shape (K,)
        kg, m, kg m2.
    moduli : tuple of float
        E* and G*, Pa.
    friction : float
    """

    normal: np.ndarray
    tangent: np.ndarray
    approach: float
    drift: float
    turns: np.ndarray
    masses: np.ndarray
    radii: np.ndarray
    inertias: np.ndarray
    moduli: tuple[float, float]
    friction: float

    @classmethod
    def of(cls, grains: Spheres, law: HertzMindlinLaw) -> "Collision":
        """Two spheres, or one above the floor."""
        normal, velocity = np.array([0.0, 0.0, -1.0]), grains.velocity[:, 0]
        moduli, friction = (law.wall_effective_modulus, law.wall_shear_modulus), law.wall_friction
        if grains.count == 2:
            branch = grains.position[:, 1] - grains.position[:, 0]
            normal, velocity = branch / np.linalg.norm(branch), velocity - grains.velocity[:, 1]
            moduli, friction = (law.effective_modulus, law.shear_modulus), law.friction
        relative = velocity + np.cross(grains.spin @ grains.radius, normal)
        across = relative - (relative @ normal) * normal
        tangent = across / np.linalg.norm(across)
        return cls(
            normal=normal,
            tangent=tangent,
            approach=float(relative @ normal),
            drift=float(velocity @ tangent),
            turns=np.cross(normal, tangent) @ grains.spin,
            masses=grains.mass,
            radii=grains.radius,
            inertias=grains.inertia,
            moduli=moduli,
            friction=friction,
        )

    @property
    def mass(self) -> float:
        """Reduced, kg."""
        return float(1 / (1 / self.masses).sum())

    def full_impulse(self, restitution: float) -> float:
        """Tangential impulse where they slide all the while, N s."""
        return self.friction * (1 + restitution) * self.mass * self.approach

    def slides_throughout(self, restitution: float) -> bool:
        """Whether they do, with a tenth to spare."""
        mobility = 1 / self.mass + float((self.radii**2 / self.inertias).sum())
        sliding = self.drift + float(self.radii @ self.turns)
        return sliding > 1.1 * self.full_impulse(restitution) * mobility


def tangential_impulse(collision: Collision, restitution: float) -> tuple[float, float]:
    """Impulse against the sliding, N s, and its moment about the first sphere, N m s.

    That of `HertzMindlinLaw`, with the lever that the overlap leaves.
    """
    one = collision
    (modulus, shear), mass = one.moduli, one.mass
    radius = float(1 / (1 / one.radii).sum())
    step = float(hertz_time(mass, radius, modulus, one.approach)) / _STEPS
    dashpot = float(damping_constants(restitution, np.array([1e9]), HERTZ)[0]) * np.sqrt(2 / 3 * mass)
    overlap, approach, drift, turns = 0.0, one.approach, one.drift, one.turns.copy()
    spring, impulse, moment = 0.0, 0.0, 0.0
    while True:
        overlap += step * approach
        if overlap <= 0:
            return impulse, moment
        levers = one.radii - 0.5 * overlap
        sliding = drift + float(levers @ turns)
        patch = np.sqrt(radius * overlap)
        stiffness, tangent = 2 * modulus * patch, 8 * shear * patch
        pressing = max(0.0, 2 / 3 * stiffness * overlap + dashpot * np.sqrt(stiffness) * approach)
        limit = one.friction * pressing
        spring = min(limit, max(-limit, spring + tangent * sliding * step))
        force = min(limit, max(-limit, spring + dashpot * np.sqrt(tangent) * sliding))
        approach -= step * pressing / mass
        drift -= step * force / mass
        turns -= step * force * levers / one.inertias
        impulse += step * force
        moment += step * force * float(levers[0])
