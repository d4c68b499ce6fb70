"""Subsets followed from picture to picture, as GeoPIV-RG keeps them.

Its results are one array `data` of N subsets, 1 + F columns and three pages: the first column holds the
subsets' numbers, column 1 + k where each is in the k-th picture, counted from one. Pages are x, y and the
correlation coefficient. Places are pixels of the picture, counted from 1 at the first one's centre, y
downwards, of the middle of a subset (Stanier, Blaber, Take, White, *Can. Geotech. J.* 53, 2016).

Between two pictures a subset moves from one of its places to the next: forward, from where it is at first.
"""

from pathlib import Path
from typing import Any

import numpy as np

from soft.flow.field import FlowError
from soft.flow.grid import Grid

VARIABLE = "data"
_PAGES = 3


def holds_trajectories(content: dict[str, Any]) -> bool:
    """Tell whether the variables of a file are trajectories, not a grid x, y, u, v."""
    return "x" not in content and VARIABLE in content


def count_steps(content: dict[str, Any], path: Path) -> int:
    """How many picture pairs they tell of."""
    return _places(content, path).shape[1] - 1


def read_step(content: dict[str, Any], index: int, path: Path) -> Grid:
    """Return the vectors of the picture pair `index`: of all subsets that are known in its first picture.

    Raises
    ------
    FlowError
        If `data` is not as described, or tells of fewer pictures.
    """
    places = _places(content, path)
    if index + 1 >= places.shape[1]:
        raise FlowError(f"{path}: {VARIABLE}: tells of {places.shape[1]} pictures: none for pair {index}")
    before, after = places[:, index], places[:, index + 1]
    there = np.isfinite(before).all(axis=1)
    (x, y), (u, v) = before[there].T, (after - before)[there].T
    return Grid(x, y, u, v, np.isfinite(u) & np.isfinite(v))


def _places(content: dict[str, Any], path: Path) -> np.ndarray:
    """Of the subsets in every picture: (N, F, 2) float64, px."""
    data = np.asarray(content[VARIABLE])
    if data.dtype.kind not in "fiu" or data.ndim != _PAGES or data.shape[2] < 2 or data.shape[1] < _PAGES:
        raise FlowError(
            f"{path}: {VARIABLE}: {data.dtype} of shape {data.shape}: must be numbers, subsets x "
            f"(1 + pictures) x 3, of two pictures at least"
        )
    numbers = data[:, 0, 0].astype(float)
    if not (numbers == np.rint(numbers)).all() or np.unique(numbers).size < numbers.size:
        raise FlowError(f"{path}: {VARIABLE}: first column: must be the subsets' numbers, each once")
    return data[:, 1:, :2].astype(float)
