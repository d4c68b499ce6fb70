"""Motion between the nodes of a grid, so that a moving region and its boundary can be told of one, too."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from scipy.spatial import Delaunay

_LEAST_NODES = 4

_LONGEST = 1.25
"""Longest side of a triangle of nodes that is filled, over the usual one: a missing node leaves a hole."""


@dataclass(frozen=True, eq=False)
class BetweenNodes:
    """A grid's motion, linear between its nodes.

    Attributes
    ----------
    displacement : (H, W, 2) float32
        (u, v) in px; NaN outside soil, beyond the outermost nodes and where a node between was not measured.
    spacing : float
        Px from a node to the next one; 0 where there are too few.
    """

    displacement: np.ndarray
    spacing: float


def between_nodes(displacement: np.ndarray, nodes: np.ndarray, soil: np.ndarray) -> BetweenNodes:
    """Take motion as linear between the nodes it was measured at (Delaunay's triangles).

    Parameters
    ----------
    displacement : (H, W, 2) array
        (u, v) in px at the pixels that hold a node, NaN elsewhere and where not measured.
    nodes : (H, W, 2) array
        x, y in px of these nodes.
    soil : (H, W) bool
        Where soil is; nothing is told elsewhere.
    """
    from scipy.spatial import Delaunay, QhullError

    held = soil & np.isfinite(displacement).all(axis=2) & np.isfinite(nodes).all(axis=2)
    filled = np.full(displacement.shape, np.nan, np.float32)
    places, vectors = nodes[held].astype(np.float64), displacement[held].astype(np.float64)
    try:
        triangles = Delaunay(places) if len(places) >= _LEAST_NODES else None
    except QhullError:  # all on a line
        triangles = None
    if triangles is None:
        return BetweenNodes(filled, 0.0)
    sides = _sides(places[triangles.simplices])
    filled[soil] = _linear(triangles, vectors, sides, np.argwhere(soil)[:, ::-1].astype(np.float64))
    return BetweenNodes(filled, float(np.median(sides.min(axis=1))))


def _sides(corners: np.ndarray) -> np.ndarray:
    """Lengths (T, 3) of the sides of triangles (T, 3, 2), px."""
    return np.asarray(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2))


def _linear(triangles: "Delaunay", vectors: np.ndarray, sides: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Vectors (N, 2) at points (N, 2) by those at the corners around; NaN in none or too large a triangle."""
    found = triangles.find_simplex(points)
    longest = sides.max(axis=1)
    known = (found >= 0) & (longest <= _LONGEST * np.median(longest))[found]
    inside = found[known]
    # Barycentric coordinates: scipy keeps the inverse matrix and the last corner of each triangle.
    matrix, corner = triangles.transform[inside, :2], triangles.transform[inside, 2]
    first = np.einsum("nij,nj->ni", matrix, points[known] - corner)
    weights = np.concatenate([first, 1 - first.sum(axis=1, keepdims=True)], axis=1)
    values = np.full((len(points), 2), np.nan)
    values[known] = np.einsum("ni,nij->nj", weights, vectors[triangles.simplices[inside]])
    return values
