"""How sure, for methods that do not say: a plain estimate, not calibrated.

The larger of two, for each component:

- noise: what a least-squares fit of one motion to the brightness equations within a window as large as the
  method's would make of the pictures' disagreement (its local variance after warping, so that noise, changes
  of light and wrong motion all count);
- where motion was measured there and back: how far the two miss each other, as root mean square over the same
  window; each of the two carries half of the variance.

Errors that are alike over the window, or there and back, show in neither: where motion is smooth it is too
small as a rule, and at breaks of the motion by far.
"""

import numpy as np

from soft.flow.consistency import landing

_LEAST_SHARE = 1e-4
"""The smaller eigenvalue of the structure tensor is taken to be at least this share of the larger one."""


def plain_uncertainty(
    first: np.ndarray,
    second: np.ndarray,
    forward: np.ndarray,
    back: np.ndarray | None,
    *,
    window: float,
) -> np.ndarray:
    """One sigma of u and of v, px: (H, W, 2) float32; NaN where motion is not known.

    Parameters
    ----------
    first, second : (H, W) float32
        Grey, 0-255.
    forward : (H, W, 2) float32
        Measured displacement, px.
    back : (H, W, 2) float32, optional
        The way back from where that ends, px (`consistency.read_back`).
    window : float
        Side of the square that the method averages over, in effect, px.
    """
    side = max(3, round(window) | 1)
    known = np.isfinite(forward).all(axis=2)
    variance = _by_noise(first, second, forward, known, side) * (side / window) ** 2
    if back is not None:
        missed = np.square(forward + back) / 2
        both = np.isfinite(missed).all(axis=2)
        variance = np.maximum(variance, _averaged(np.where(both[:, :, None], missed, 0), both, side))
    return np.where(known[:, :, None], np.sqrt(variance), np.nan).astype(np.float32)


def _by_noise(
    first: np.ndarray, second: np.ndarray, forward: np.ndarray, known: np.ndarray, side: int
) -> np.ndarray:
    """Variance of u and of v fitted in a square of `side` px, (H, W, 2) px^2."""
    import cv2

    warped = cv2.remap(second, *landing(forward), cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    residual = np.where(known, warped - first, 0)
    slopes = [cv2.Sobel(first, cv2.CV_32F, dx, 1 - dx, ksize=1, scale=0.5) for dx in (1, 0)]
    jx, jy = (np.where(known, slope, 0) for slope in slopes)
    sums = _averaged(np.stack([jx * jx, jx * jy, jy * jy, residual, residual**2], axis=2), known, side)
    xx, xy, yy, mean, square = np.moveaxis(sums, 2, 0)
    floor = _LEAST_SHARE * (xx + yy) + np.finfo(np.float32).tiny
    determinant = np.maximum(xx * yy - xy * xy, floor * (xx + yy) + np.finfo(np.float32).tiny)
    count = side * side
    noise = np.maximum(square - mean * mean, 0) / count
    return np.stack([noise * yy / determinant, noise * xx / determinant], axis=2)


def _averaged(values: np.ndarray, known: np.ndarray, side: int) -> np.ndarray:
    """Mean over the known pixels of a square around each one; `values` is 0 where not known."""
    import cv2

    total = cv2.boxFilter(values.astype(np.float32), -1, (side, side), borderType=cv2.BORDER_CONSTANT)
    share = cv2.boxFilter(known.astype(np.float32), -1, (side, side), borderType=cv2.BORDER_CONSTANT)
    return total / np.maximum(share, 0.5 / (side * side))[:, :, None]
