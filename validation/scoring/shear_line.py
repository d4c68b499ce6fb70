"""The line of greatest true shear rate: where soil shears most, told apart from any clustering."""

import numpy as np

_SCALE = 4.0
"""Standard deviation of the Gaussian that the shear rate is smoothed with first, px."""
_LEAST_SHARE = 0.5
"""Of the soil's great shear rates (99 %): what a crest must reach to count."""
_LEAST_POINTS = 25
"""Crests of fewer pixels are specks."""
_FROM_OUTLINE = 3
"""Crests nearer to the soil's outline or the border than this, px, are left out."""


def shear_line(strain_rate: np.ndarray, soil: np.ndarray) -> np.ndarray:
    """Pixels on the crests of the shear rate.

    On a crest, the shear rate falls off to both sides across it (along the direction in which it curves down
    most). Only crests in soil count that are at least half as high as the great shear rates of this picture.

    Parameters
    ----------
    strain_rate : (H, W) array
        Equivalent shear strain a frame, as in the truth.
    soil : (H, W) bool
        Where soil is.

    Returns
    -------
    (N, 2) float64
        x, y in px; empty where nothing shears.
    """
    from scipy.ndimage import binary_erosion

    known = soil & np.isfinite(strain_rate)
    if not known.any():
        return np.empty((0, 2))
    smooth, curvature = _smoothed(np.where(known, strain_rate, 0.0), known)
    least = _LEAST_SHARE * float(np.percentile(smooth[known], 99))
    inner = binary_erosion(known, iterations=_FROM_OUTLINE)
    crest = inner & (smooth >= max(least, np.finfo(float).tiny)) & _is_crest(smooth, *curvature)
    rows, columns = np.nonzero(_without_specks(crest))
    return np.stack([columns, rows], axis=1).astype(np.float64)


def _smoothed(values: np.ndarray, known: np.ndarray) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
    """Mean over known pixels, and its second derivatives xx, xy, yy."""
    from scipy.ndimage import gaussian_filter

    weight = gaussian_filter(known.astype(np.float64), _SCALE)
    smooth = gaussian_filter(values.astype(np.float64), _SCALE) / np.maximum(weight, 1e-6)
    by_y, by_x = np.gradient(smooth)
    (_, xx), (yy, xy) = np.gradient(by_x), np.gradient(by_y)
    return smooth, (xx, xy, yy)


def _is_crest(smooth: np.ndarray, xx: np.ndarray, xy: np.ndarray, yy: np.ndarray) -> np.ndarray:
    """Pixels that are above both neighbours across the direction of strongest downward curvature."""
    from scipy.ndimage import map_coordinates

    # Of a symmetric 2 x 2 matrix: the eigenvector of the smaller eigenvalue.
    angle = 0.5 * np.arctan2(2 * xy, xx - yy) + np.pi / 2
    smaller = (xx + yy) / 2 - np.hypot((xx - yy) / 2, xy)
    rows, columns = np.indices(smooth.shape, dtype=np.float64)
    down, right = np.sin(angle), np.cos(angle)
    sides = [
        map_coordinates(smooth, [rows + way * down, columns + way * right], order=1, mode="nearest")
        for way in (1, -1)
    ]
    return (smaller < 0) & (smooth >= sides[0]) & (smooth >= sides[1])


def _without_specks(mask: np.ndarray) -> np.ndarray:
    from scipy.ndimage import label

    labels, _ = label(mask, np.ones((3, 3)))
    kept = np.bincount(labels.ravel()) >= _LEAST_POINTS
    kept[0] = False
    return np.asarray(kept[labels])
