"""Distance between lines in a picture."""

from collections.abc import Sequence

import numpy as np

_STEP = 0.25
"""Lines are compared at points this far apart, px: what lies between them is off by 0.13 px at most."""


def points_along(lines: Sequence[np.ndarray]) -> np.ndarray:
    """Points at even steps along lines, (M, 2) x, y in px; each stands for as much length as any other.

    Parameters
    ----------
    lines : sequence of (N, 2) arrays
        x, y in px.
    """
    return np.concatenate([_even(line) for line in lines]) if len(lines) else np.empty((0, 2))


def distances(points: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Distance of each of the points to the nearest of others, px; infinite if there are none."""
    from scipy.spatial import KDTree

    if not len(others):
        return np.full(len(points), np.inf)
    return np.asarray(KDTree(others).query(points)[0])


def _even(line: np.ndarray) -> np.ndarray:
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    places = np.linspace(0, along[-1], max(2, int(np.ceil(along[-1] / _STEP)) + 1))
    return np.stack([np.interp(places, along, line[:, k]) for k in (0, 1)], axis=1)
