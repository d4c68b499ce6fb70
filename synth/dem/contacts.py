"""The forces between grains at one moment."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Contacts:
    """Pairs of grains that press on each other, K of them; forces per metre of width.

    The normal points from the first grain to the second; the tangent is the normal turned counter-clockwise
    by a quarter.

    Attributes
    ----------
    pairs : ndarray of int32, shape (2, K)
        Indices of the grains, the first below the second.
    normal : ndarray, shape (K,)
        With which they push each other apart, N/m.
    tangential : ndarray, shape (K,)
        On the first grain along the tangent, and on the second against it, N/m.
    """

    pairs: np.ndarray
    normal: np.ndarray
    tangential: np.ndarray

    @classmethod
    def none(cls) -> "Contacts":
        """No pair."""
        return cls(np.zeros((2, 0), np.int32), np.zeros(0), np.zeros(0))

    @classmethod
    def of_forces(cls, position: np.ndarray, pairs: np.ndarray, force: np.ndarray) -> "Contacts":
        """Split forces on the first grains (K, 2), N/m; pairs without a force are left out.

        Parameters
        ----------
        position : ndarray, shape (2, N)
            Of the grains, m.
        """
        pairs, force = pairs[:, force.any(axis=1)], force[force.any(axis=1)]
        branch = position[:, pairs[1]] - position[:, pairs[0]]
        x, z = branch / np.hypot(*branch)
        return cls(pairs, -(force[:, 0] * x + force[:, 1] * z), force[:, 1] * x - force[:, 0] * z)
