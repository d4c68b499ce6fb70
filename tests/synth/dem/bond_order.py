"""How crystalline a packing of grains is."""

import numpy as np
from scipy.spatial import Delaunay


def bond_orientational_order(position: np.ndarray, *, reach: float) -> float:
    """Mean over the grains of ``|psi6|``: 1 where six neighbours stand around at even angles.

    ``psi6`` of a grain is the mean of ``exp(6 i theta)`` over its Delaunay neighbours, of which it forgets
    those beyond `reach`. It is averaged once over a grain and these neighbours, so that neighbouring hexagons
    must point the same way; without that, even disorder has a large value (Lechner and Dellago, *J. Chem.
    Phys.* 129, 2008, for the average).

    Parameters
    ----------
    position : ndarray, shape (2, N)
        Centres, m.
    reach : float
        m; about one and a half diameters.
    """
    start, neighbour = _neighbours(position, reach)
    angle = np.arctan2(*(position[:, neighbour] - position[:, start])[::-1])
    count = np.bincount(start, minlength=position.shape[1])
    psi = _sum_by(start, np.exp(6j * angle), count.size) / np.maximum(count, 1)
    averaged = (psi + _sum_by(start, psi[neighbour], count.size)) / (1 + count)
    return float(np.abs(averaged[count > 0]).mean())


def _neighbours(position: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Grain and neighbour, every pair in both directions."""
    first, neighbours = Delaunay(position.T).vertex_neighbor_vertices
    start = np.repeat(np.arange(position.shape[1]), np.diff(first))
    near = np.hypot(*(position[:, start] - position[:, neighbours])) < reach
    return start[near], neighbours[near]


def _sum_by(group: np.ndarray, value: np.ndarray, count: int) -> np.ndarray:
    real = np.bincount(group, value.real, minlength=count)
    return real + 1j * np.bincount(group, value.imag, minlength=count)
