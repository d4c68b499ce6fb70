"""The gradient of a measured displacement: affine fits that do not look across what was not measured."""

import math

import numpy as np

# A window reaches this many scales from its centre.
REACH = 2.0

# Least spread (variance) in px^2, in any direction, of the pixels of a fit: two columns have 0.25.
LEAST_SPREAD = 0.2

# Rows that are worked on at a time: what is visible from them is held for every place of the window.
BAND_ROWS = 64


def displacement_gradient(
    displacement: np.ndarray, measured: np.ndarray, *, scale: float = 3.0
) -> np.ndarray:
    """Fit an affine motion around each pixel, by least squares.

    A pixel of the window counts by a Gaussian of its distance, and only if it is seen from the centre: all
    pixels on the way are measured, too. So nothing is mixed across the implement, a grouser, or a gap. An
    affine field is given exactly, up to its edges; detail smaller than `scale` is smoothed away.

    Parameters
    ----------
    displacement : (H, W, 2) array
        (u, v) in px.
    measured : (H, W) bool
        Where to use it: valid, and soil.
    scale : float, optional
        Standard deviation of the Gaussian in px; the window reaches twice as far.

    Returns
    -------
    (H, W, 2, 2) float32
        d(u, v)_i / d(x, y)_j in px/px at [.., i, j]; NaN where not measured, and where too few pixels are
        seen to tell.

    Raises
    ------
    ValueError
        If shapes differ or `scale` is not above 0.
    """
    if displacement.shape != (*measured.shape, 2):
        raise ValueError(f"measured: shape {measured.shape}: must be {displacement.shape[:2]}")
    if not 0 < scale < math.inf:
        raise ValueError(f"scale: {scale!r}: must be a number of px above 0")
    radius = max(1, math.ceil(REACH * scale))
    used = np.asarray(measured, bool) & np.isfinite(displacement).all(axis=2)
    values = np.where(used[:, :, None], displacement, 0.0).astype(np.float64)
    used, values = (np.pad(a, [(radius, radius)] * 2 + [(0, 0)] * (a.ndim - 2)) for a in (used, values))
    gradient = np.empty((*measured.shape, 2, 2), np.float32)
    offsets = _offsets(radius)
    for top in range(0, len(measured), BAND_ROWS):
        bottom = min(top + BAND_ROWS, len(measured))
        rows = slice(top, bottom + 2 * radius)
        gradient[top:bottom] = _fitted(values[rows], used[rows], offsets, radius, scale)
    return gradient


def _offsets(radius: int) -> list[tuple[int, int]]:
    """Places (dx, dy) of a round window, from the centre outwards."""
    reach = range(-radius, radius + 1)
    inside = [(dx, dy) for dy in reach for dx in reach if dx * dx + dy * dy <= radius * radius]
    return sorted(inside, key=lambda place: (place[0] ** 2 + place[1] ** 2, place))


def _before(dx: int, dy: int) -> tuple[int, int]:
    """The place one step nearer to the centre, on the straight way to it."""
    longest = max(abs(dx), abs(dy))
    nearer = (longest - 1) / longest
    return round(dx * nearer), round(dy * nearer)


def _fitted(
    values: np.ndarray, used: np.ndarray, offsets: list[tuple[int, int]], radius: int, scale: float
) -> np.ndarray:
    """Gradients (h, w, 2, 2) of a band that is padded by `radius` all around."""
    height, width = (side - 2 * radius for side in used.shape)

    def at(array: np.ndarray, dx: int, dy: int) -> np.ndarray:
        return array[radius + dy : radius + dy + height, radius + dx : radius + dx + width]

    seen = {(0, 0): at(used, 0, 0)}
    # Sums of 1, x, y, x^2, xy, y^2, and of u and v with 1, x and y.
    moments, mixed = np.zeros((6, height, width)), np.zeros((2, 3, height, width))
    for dx, dy in offsets:
        if (dx, dy) != (0, 0):
            seen[dx, dy] = seen[_before(dx, dy)] & at(used, dx, dy)
        weight = seen[dx, dy] * math.exp(-(dx * dx + dy * dy) / (2 * scale * scale))
        for moment, factor in zip(moments, (1, dx, dy, dx * dx, dx * dy, dy * dy), strict=True):
            if factor:
                moment += factor * weight
        for i in (0, 1):
            part = weight * at(values[:, :, i], dx, dy)
            for moment, factor in zip(mixed[i], (1, dx, dy), strict=True):
                if factor:
                    moment += factor * part
    return _solved(moments, mixed, seen[0, 0])


def _solved(moments: np.ndarray, mixed: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Slopes of the fitted planes."""
    with np.errstate(invalid="ignore", divide="ignore"):
        total = moments[0]
        x, y = moments[1] / total, moments[2] / total
        xx, xy, yy = moments[3] / total - x * x, moments[4] / total - x * y, moments[5] / total - y * y
        determinant = xx * yy - xy * xy
        least = (xx + yy) / 2 - np.hypot((xx - yy) / 2, xy)
        gradient = np.empty((*known.shape, 2, 2))
        for i in (0, 1):
            mean = mixed[i, 0] / total
            along_x, along_y = mixed[i, 1] / total - x * mean, mixed[i, 2] / total - y * mean
            gradient[:, :, i, 0] = (yy * along_x - xy * along_y) / determinant
            gradient[:, :, i, 1] = (xx * along_y - xy * along_x) / determinant
        gradient[~(known & (least >= LEAST_SPREAD))] = np.nan
    return gradient
