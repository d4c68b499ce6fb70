"""Dashpots that give the restitution asked for, at the time steps that are taken.

A dashpot that is chosen for infinitely fine steps gives too low a rebound at a step of a twentieth of the
collision, since its force belongs to the velocity of half a step before. So the constant is solved for
against what the solver does: semi-implicit Euler steps of one collision, from force to velocity to place,
averaged over the phases of a step at which a collision can begin. Single collisions scatter about that mean.
"""

from functools import lru_cache

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

LINEAR, HERTZ = 1.0, 1.5
"""Exponents of the overlap in the spring's force."""
_PHASES = 32
"""Places within a time step at which the collisions that are averaged begin."""
_TIMES = {LINEAR: float(np.pi), HERTZ: 2.9432 * 1.25**0.4}
"""Duration of an undamped collision in the units of `mean_restitution`; compare `contact_law.hertz_time`."""
_TABLE = (10, 14, 20, 28, 40, 80, 160)
"""Time steps in a collision for which constants are solved; between them they are interpolated."""


def mean_restitution(damping: float, steps_per_contact: float, exponent: float) -> float:
    """Mean rebound / impact speed of collisions that begin at all phases of a time step.

    In units in which mass, impact speed and spring constant are one: ``x'' = - max(0, x^n + d x^q x')``, in
    which q is 0 for the linear spring and 1/4 for Hertz, so that restitution does not depend on impact speed.

    Parameters
    ----------
    damping : float
        The constant d: twice the damping ratio for the linear spring.
    steps_per_contact : float
        Time steps in an undamped collision.
    exponent : {LINEAR, HERTZ}
        Of the overlap in the spring's force, n.
    """
    step = _TIMES[exponent] / steps_per_contact
    overlap = (np.arange(_PHASES) + 0.5) / _PHASES * step
    approach = np.ones(_PHASES)
    for _ in range(int(3 * steps_per_contact) + 2):
        touching = np.maximum(overlap, 0.0)
        spring = touching if exponent == LINEAR else touching * np.sqrt(touching)
        dashpot = (
            damping * approach if exponent == LINEAR else damping * np.sqrt(np.sqrt(touching)) * approach
        )
        force = np.where(overlap > 0, np.maximum(0.0, spring + dashpot), 0.0)
        approach = approach - step * force
        overlap = overlap + step * approach
        if (overlap <= 0).all():
            break
    return float(-approach.mean())


def damping_constants(restitution: float, steps_per_contact: np.ndarray, exponent: float) -> np.ndarray:
    """Constants d of `mean_restitution` that give the restitution asked for, shape of `steps_per_contact`.

    Collisions of less than ten steps get the constant for ten: no scene is run with such.
    """
    steps = np.maximum(np.asarray(steps_per_contact, float), _TABLE[0])
    if restitution == 1:
        return np.zeros(steps.shape)
    return np.asarray(_constants(restitution, exponent)(1 / steps))


@lru_cache
def _constants(restitution: float, exponent: float) -> PchipInterpolator:
    """Constants by the reciprocal of the steps in a collision; the finest stand for any finer."""
    found = [_constant(restitution, steps, exponent) for steps in _TABLE]
    inverse = [0.0, *(1 / steps for steps in reversed(_TABLE))]
    # Beyond the finest, the error falls with the step as between the two finest.
    slope = (found[-2] - found[-1]) / (1 / _TABLE[-2] - 1 / _TABLE[-1])
    return PchipInterpolator(inverse, [found[-1] - slope / _TABLE[-1], *reversed(found)])


def _constant(restitution: float, steps_per_contact: float, exponent: float) -> float:
    def excess(damping: float) -> float:
        return mean_restitution(damping, steps_per_contact, exponent) - restitution

    strongest = 0.5
    while excess(strongest) > 0:
        strongest *= 1.5
    return float(brentq(excess, 0.0, strongest, xtol=1e-9))
