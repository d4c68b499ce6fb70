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
from soft.flow.field import known

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
    told = known(forward)
    average = _Average(told, side)
    variances = [v * (side / window) ** 2 for v in _by_noise(first, second, forward, told, average)]
    if back is not None:
        missed = forward + back
        both = known(missed)
        there_and_back = _Average(both, side)
        variances = [np.maximum(v, there_and_back(missed[:, :, k] ** 2) / 2) for k, v in enumerate(variances)]
    sigma = np.sqrt(np.stack(variances, axis=-1), dtype=np.float32)
    sigma[~told] = np.nan
    return sigma


def _by_noise(
    first: np.ndarray, second: np.ndarray, forward: np.ndarray, told: np.ndarray, average: "_Average"
) -> tuple[np.ndarray, np.ndarray]:
    """Variance of u and of v fitted in a square, (H, W) px^2 each."""
    import cv2

    warped = cv2.remap(second, *landing(forward), cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    residual = warped - first
    jx, jy = (cv2.Sobel(first, cv2.CV_32F, dx, 1 - dx, ksize=1, scale=0.5) for dx in (1, 0))
    xx, xy, yy = average(jx * jx), average(jx * jy), average(jy * jy)
    noise = np.maximum(average(residual**2) - average(residual) ** 2, 0) / average.count
    trace = xx + yy + np.finfo(np.float32).tiny
    determinant = np.maximum(xx * yy - xy * xy, _LEAST_SHARE * trace * trace)
    noise /= np.maximum(determinant, np.finfo(np.float32).tiny)
    return noise * yy, noise * xx


class _Average:
    """Mean over those pixels of a square around each one that count; what does not is set to 0 in place."""

    def __init__(self, counting: np.ndarray, side: int) -> None:
        self.count = side * side
        self._side = side
        self._out = ~counting
        # Kept above zero where nothing in a square counts.
        self._share = np.maximum(self._boxed(counting.astype(np.float32)), 0.5 / self.count)

    def __call__(self, values: np.ndarray) -> np.ndarray:
        values[self._out] = 0
        return self._boxed(values) / self._share

    def _boxed(self, values: np.ndarray) -> np.ndarray:
        import cv2

        return cv2.boxFilter(values, cv2.CV_32F, (self._side, self._side), borderType=cv2.BORDER_CONSTANT)
