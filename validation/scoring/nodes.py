"""Measured less true displacement, where the measurement was made.

Most methods tell of every pixel. A grid's vector was measured at its node, which lies between pixels as a
rule. It is not interpolated; the truth is taken at the node: between the four pixels around it linearly where
these move alike, else (at a break of the motion, at soil's edge) from the nearest one, so that no motion is
made up that nothing has.
"""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

_ALIKE = 0.1
"""Motions of the four pixels around a node differ by at most this much to count as alike, px."""


def difference_at(displacement: np.ndarray, truth: np.ndarray, nodes: np.ndarray | None) -> np.ndarray:
    """Measured less true displacement, (H, W, 2) px; NaN where not measured or the truth is not known.

    Parameters
    ----------
    displacement, truth : (H, W, 2) array
        Px; NaN where not known.
    nodes : (H, W, 2) array, optional
        (x, y) px of the place that each pixel's displacement was measured at, NaN for none; None: the
        pixels' centres.
    """
    if nodes is None:
        return displacement - truth
    difference = np.full(truth.shape, np.nan, np.float32)
    held = has_node(nodes)
    difference[held] = displacement[held] - truth_at(truth, nodes[held])
    return difference


def stacked(data: "xr.Dataset", *names: str) -> np.ndarray:
    """Variables (H, W) as one array (H, W, N)."""
    return np.stack([data[name].values for name in names], axis=-1)


def has_node(nodes: np.ndarray) -> np.ndarray:
    """Pixels that a node is in: (H, W) bool."""
    return np.isfinite(nodes).all(axis=2)


def truth_at(truth: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Displacement (N, 2) px at places (N, 2), each (x, y) px, from that of the pixels (H, W, 2)."""
    height, width = truth.shape[:2]
    places = np.clip(places, 0, [width - 1, height - 1])
    column, row = (np.minimum(places[:, k].astype(np.intp), n - 2) for k, n in ((0, width), (1, height)))
    right, down = places[:, 0] - column, places[:, 1] - row
    corners = np.stack([truth[row + dy, column + dx] for dy in (0, 1) for dx in (0, 1)])
    weights = np.stack([wy * wx for wy in (1 - down, down) for wx in (1 - right, right)])
    nearest = truth[np.rint(places[:, 1]).astype(np.intp), np.rint(places[:, 0]).astype(np.intp)]
    # A comparison with NaN is false: beside unknown truth, the nearest pixel counts.
    alike = (np.ptp(corners, axis=0) <= _ALIKE).all(axis=1)
    return np.where(alike[:, None], (weights[:, :, None] * corners).sum(axis=0), nearest)
