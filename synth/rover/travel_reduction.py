"""Travel reduction and velocity as the paper has them (Eqs. 8, 9).

Travel reduction is the loss of velocity against the same vehicle without a drawbar pull, its wheels turning
alike.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray


def travel_reduction(velocity: ArrayLike, self_propelled: float) -> NDArray:
    """Eq. 8, as a ratio: 0 without loss, 1 where the vehicle stands, above 1 where it is pulled back.

    Parameters
    ----------
    velocity : array_like
        At some drawbar pull, m/s or m a cycle.
    self_propelled : float
        Without drawbar pull, in the same unit.

    Raises
    ------
    ValueError
        The vehicle does not move by itself.
    """
    if not self_propelled > 0:
        raise ValueError(
            f"self-propelled velocity {self_propelled:g}: the vehicle does not move without a load"
        )
    return (self_propelled - np.asarray(velocity, float)) / self_propelled


def velocities(distances: ArrayLike, interval: float) -> NDArray:
    """Eq. 9: velocity from distances measured every `interval` (s, or 1 for a cycle), one less than these."""
    return np.diff(np.asarray(distances, float)) / interval


def pull_at(reduction: float, pulls: ArrayLike, reductions: ArrayLike) -> float | None:
    """Drawbar pull at which the travel reduction first reaches a value, between measured points linearly.

    Returns
    -------
    float or None
        In the unit of `pulls`; None where no point got there, or already the first was beyond.
    """
    pull, reached = np.asarray(pulls, float), np.asarray(reductions, float)
    beyond = np.flatnonzero(reached >= reduction)
    if beyond.size == 0 or beyond[0] == 0:
        return None
    after = int(beyond[0])
    before = after - 1
    share = (reduction - reached[before]) / (reached[after] - reached[before])
    return float(pull[before] + share * (pull[after] - pull[before]))
