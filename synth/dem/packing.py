"""How grains are packed: solid fraction, void ratio, and how crystalline they are."""

from collections.abc import Callable

import numpy as np
from scipy.spatial import Delaunay

from synth.dem.grains import Grains, Spheres


def solid_fraction(grains: Grains, *, left: float, right: float, bottom: float, top: float) -> float:
    """Share of a rectangle's area (bounds in m) that grains fill.

    Discs that its sides cut count by the share inside, exactly; those few at its corners, nearly. Overlaps
    count twice: they are a thousandth of a diameter.
    """
    inside = _share_inside(grains, _disc_beyond, left, right, bottom, top)
    return float((inside * np.pi * grains.radius**2).sum() / ((right - left) * (top - bottom)))


def slab_solid_fraction(
    grains: Spheres, *, left: float, right: float, bottom: float, top: float, thickness: float
) -> float:
    """Share of a slab's volume (bounds and thickness in m) that spheres fill, loose layers at glass too."""
    inside = _share_inside(grains, _sphere_beyond, left, right, bottom, top)
    return float((inside * grains.volume).sum() / ((right - left) * (top - bottom) * thickness))


def _share_inside(
    grains: Grains,
    share_beyond: Callable[[np.ndarray], np.ndarray],
    left: float,
    right: float,
    bottom: float,
    top: float,
) -> np.ndarray:
    """Share of every grain within a rectangle, shape (N,)."""
    (x, z), radius = grains.in_plane, grains.radius
    inside = share_beyond((x - left) / radius) * share_beyond((right - x) / radius)
    inside *= share_beyond((z - bottom) / radius) * share_beyond((top - z) / radius)
    return inside


def _disc_beyond(depth: np.ndarray) -> np.ndarray:
    """Share of a disc on one side of a line: its centre lies so many radii within that side."""
    t = np.clip(depth, -1.0, 1.0)
    return np.asarray(1 - (np.arccos(t) - t * np.sqrt(1 - t**2)) / np.pi)


def _sphere_beyond(depth: np.ndarray) -> np.ndarray:
    """Share of a sphere on one side of a plane: its centre lies so many radii within that side."""
    t = np.clip(depth, -1.0, 1.0)
    return np.asarray((1 + t) ** 2 * (2 - t) / 4)


def void_ratio(solid: float) -> float:
    """Area of voids / area of grains, of a packing of that solid fraction."""
    return 1 / solid - 1


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
