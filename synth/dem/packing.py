"""How grains are packed: solid fraction and void ratio."""

from collections.abc import Callable

import numpy as np

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
