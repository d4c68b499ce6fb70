"""The linear contact law's constants, from what is asked for to what the kernels need.

Normal force: spring and dashpot, never attractive. Tangential force: a spring whose *force* is carried from
step to step, and a dashpot, both under the Coulomb limit. Rolling: an elastic-plastic moment (model C of Ai,
Chen, Rotter, Ooi, *Powder Technology* 206, 2011, without its viscous part).
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

SMALLEST_RESTITUTION = float(np.exp(-2))
"""Below, a dashpot would have to be over-critical."""


@dataclass(frozen=True)
class ContactLaw:
    """Constants of contacts, per metre of width.

    Attributes
    ----------
    normal_stiffness, tangential_stiffness : float
        N/m per metre of width.
    damping_ratio : float
        Dashpot constant / critical one, of the normal and the tangential direction.
    friction, wall_friction, implement_friction : float
        Coulomb coefficients.
    rolling_friction : float
        Limit of the rolling moment / (normal force x reduced radius).
    """

    normal_stiffness: float
    tangential_stiffness: float
    damping_ratio: float
    friction: float
    wall_friction: float
    implement_friction: float
    rolling_friction: float


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
