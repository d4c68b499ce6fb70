"""Contact laws' constants, from what is asked for to what the kernels need.

Normal force: spring and dashpot, together never attractive, and between grains a constant cohesion while
they touch. Tangential force: a spring whose *force* is carried from step to step, and a dashpot, both under
the Coulomb limit. Rolling: an elastic-plastic moment (model C of Ai, Chen, Rotter, Ooi, *Powder Technology*
206, 2011, without its viscous part).

Springs are linear, or those of Hertz and Mindlin. The latter are for spheres only: between parallel
cylinders in plane strain, the approach of two centres under a line load depends on where in the bodies it is
measured, by a logarithm of their size (Johnson, *Contact Mechanics*, 1985, section 5.6), so that no stiffness
belongs to the contact alone.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from synth.dem.damping import HERTZ, LINEAR, damping_constants

if TYPE_CHECKING:
    from synth.dem.grains import Grains

SMALLEST_RESTITUTION = float(np.exp(-2))
"""Below, a dashpot would have to be over-critical."""


@dataclass(frozen=True)
class ContactLaw:
    """Constants of linear contacts; of discs per metre of width.

    Attributes
    ----------
    normal_stiffness, tangential_stiffness : float
        N/m; of discs per metre of width.
    damping_ratio : float
        Dashpot constant / critical one, of the normal and the tangential direction, for infinitely fine time
        steps; the solver takes what gives the same restitution at its own step (`contact_damping`).
    friction, wall_friction, implement_friction : float
        Coulomb coefficients.
    rolling_friction : float
        Limit of the rolling moment / (normal force x reduced radius).
    cohesion : float
        Force that parts two grains which touch: of discs in N per metre of width; of spheres per reduced
        radius, N/m. Friction's limit counts the pressing force without it.
    glass_friction : float
        Coulomb coefficient of spheres on the glass.
    back_friction : float
        Of spheres on the slab's other face; zero makes a mirror of it.
    """

    normal_stiffness: float
    tangential_stiffness: float
    damping_ratio: float
    friction: float
    wall_friction: float
    implement_friction: float
    rolling_friction: float
    cohesion: float = 0.0
    glass_friction: float = 0.0
    back_friction: float = 0.0

    @property
    def restitution(self) -> float:
        """Rebound speed / impact speed that the damping ratio gives."""
        return restitution_of(self.damping_ratio)


@dataclass(frozen=True)
class HertzMindlinLaw:
    """Constants of contacts of elastic spheres after Hertz and Mindlin (no slip).

    Normal force ``4/3 E* sqrt(R*) d^(3/2)``; tangential stiffness ``8 G* sqrt(R* d)``, by which the force of
    the step before grows, not rescaled when the normal force falls; dashpots as in Tsuji, Tanaka, Ishida,
    *Powder Technology* 71 (1992) 239, whose restitution does not depend on impact speed, with the constant of
    `synth.dem.damping` since nothing pulls.

    Attributes
    ----------
    effective_modulus, shear_modulus : float
        E* and G* of two grains, Pa (`reduced_moduli`).
    wall_effective_modulus, wall_shear_modulus : float
        Those of a grain and a wall or implement.
    restitution : float
        Rebound speed / impact speed.
    impact_speed : float
        Greatest relative speed of collisions, m/s: by it, the time step is chosen and the dashpots are
        corrected for its length. Slower collisions take longer, and rebound a little higher than asked for.
    The others are those of `ContactLaw`.
    """

    effective_modulus: float
    shear_modulus: float
    wall_effective_modulus: float
    wall_shear_modulus: float
    restitution: float
    impact_speed: float
    friction: float
    wall_friction: float
    implement_friction: float
    rolling_friction: float
    cohesion: float = 0.0
    glass_friction: float = 0.0
    back_friction: float = 0.0


Law = ContactLaw | HertzMindlinLaw


@dataclass(frozen=True)
class Material:
    """An isotropic elastic material: Young's modulus, Pa, and Poisson's ratio."""

    young_modulus: float
    poisson_ratio: float

    @property
    def shear_modulus(self) -> float:
        """Pa."""
        return self.young_modulus / (2 * (1 + self.poisson_ratio))


def reduced_moduli(first: Material, second: Material | None = None) -> tuple[float, float]:
    """E* and G* of two materials in contact, Pa; without a second one, it is rigid."""
    normal = (1 - first.poisson_ratio**2) / first.young_modulus
    shear = (2 - first.poisson_ratio) / first.shear_modulus
    if second is not None:
        normal += (1 - second.poisson_ratio**2) / second.young_modulus
        shear += (2 - second.poisson_ratio) / second.shear_modulus
    return 1 / normal, 1 / shear


def restitution_of(damping_ratio: float) -> float:
    """Rebound speed / impact speed of a spring and dashpot that never pull.

    The contact ends when the force is zero, not when the overlap is: with ``sin(phi)`` the damping ratio, the
    half swing lasts ``(pi - 2 phi) / omega_d`` and the rebound is ``exp(-tan(phi) (pi - 2 phi))`` (compare
    Schwager and Poeschel, *Granular Matter* 9, 2007).
    """
    phi = np.arcsin(damping_ratio)
    return float(np.exp(-np.tan(phi) * (np.pi - 2 * phi)))


def damping_ratio_of(restitution: float) -> float:
    """Damping ratio that gives the restitution asked for, the inverse of `restitution_of`.

    Raises
    ------
    ValueError
        The restitution is not in (exp(-2), 1].
    """
    if not SMALLEST_RESTITUTION < restitution <= 1:
        raise ValueError(
            f"restitution = {restitution}: allowed is {SMALLEST_RESTITUTION:.3f} < restitution <= 1"
        )
    if restitution == 1:
        return 0.0
    return float(brentq(lambda ratio: restitution_of(ratio) - restitution, 0.0, 1 - 1e-12))


def contact_time(mass: float, normal_stiffness: float) -> float:
    """Duration of an undamped collision of two discs of equal mass (kg/m), s."""
    return float(np.pi * np.sqrt(mass / 2 / normal_stiffness))


def largest_time_step(masses: np.ndarray, normal_stiffness: float, steps_per_contact: int) -> float:
    """Time step that resolves the shortest binary collision in so many steps, s."""
    return contact_time(float(masses.min()), normal_stiffness) / steps_per_contact


def hertz_time(
    mass: "np.ndarray | float", radius: "np.ndarray | float", effective_modulus: float, speed: float
) -> np.ndarray:
    """Duration of an undamped collision of reduced mass (kg) and radius (m) at a relative speed (m/s), s.

    ``2.9432 d / v`` with the greatest overlap ``d = (15 m v^2 / (16 sqrt(R) E*))^(2/5)`` (Johnson, *Contact
    Mechanics*, 1985, section 11.4).
    """
    overlap = (15 * np.asarray(mass) * speed**2 / (16 * np.sqrt(radius) * effective_modulus)) ** 0.4
    return np.asarray(2.9432 * overlap / speed)


def spring_force(law: Law, overlap: np.ndarray, radius: np.ndarray, *, boundary: bool = False) -> np.ndarray:
    """Normal force of springs at an overlap (m) and a reduced radius (m); N, of discs per metre of width."""
    if isinstance(law, ContactLaw):
        return law.normal_stiffness * overlap
    modulus = law.wall_effective_modulus if boundary else law.effective_modulus
    return np.asarray(4 / 3 * modulus * np.sqrt(radius) * overlap**1.5)


def shortest_contact(grains: "Grains", law: Law) -> float:
    """Duration of the shortest undamped collision, s: two of the lightest grains, or one and a wall."""
    lightest = int(grains.mass.argmin())
    mass, radius = float(grains.mass[lightest]), float(grains.radius[lightest])
    if isinstance(law, ContactLaw):
        return contact_time(mass, law.normal_stiffness)
    between = hertz_time(mass / 2, radius / 2, law.effective_modulus, law.impact_speed)
    return float(min(between, hertz_time(mass, radius, law.wall_effective_modulus, law.impact_speed)))


def time_step_of(grains: "Grains", law: Law, steps_per_contact: int) -> float:
    """Time step that resolves the shortest collision in so many steps, s.

    Hertz's contacts grow stiffer under load, and collisions at the law's impact speed must be the hardest
    there are.
    """
    return shortest_contact(grains, law) / steps_per_contact


def contact_damping(
    law: Law, mass: np.ndarray, radius: np.ndarray, time_step: float, *, boundary: bool = False
) -> np.ndarray:
    """Dashpot constant / root of the stiffness, root of kg, of contacts of a reduced mass and radius.

    The stiffness is that at the present overlap, the tangent to the force.

    Parameters
    ----------
    mass, radius : ndarray
        Reduced ones, kg and m; of discs, mass is per metre.
    time_step : float
        s.
    boundary : bool
        Contacts with walls and implement, whose reduced mass and radius are the grain's own.
    """
    if isinstance(law, ContactLaw):
        steps = np.pi * np.sqrt(mass / law.normal_stiffness) / time_step
        return damping_constants(law.restitution, steps, LINEAR) * np.sqrt(mass)
    modulus = law.wall_effective_modulus if boundary else law.effective_modulus
    steps = hertz_time(mass, radius, modulus, law.impact_speed) / time_step
    # The stiffness is that of the tangent, 3/2 of force / overlap.
    return damping_constants(law.restitution, steps, HERTZ) * np.sqrt(2 / 3 * mass)
