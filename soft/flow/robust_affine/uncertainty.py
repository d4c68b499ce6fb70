"""How sure: noise of the pictures, and motion that an affine window cannot follow.

Four variances add up:

- noise, as propagated through the fit (`windows.Fit.variance`);
- a share of what the next smaller window finds otherwise, beyond noise: at a single place too little to be
  told from noise, but its mean around a place is;
- a multiple of what was mended after windows were chosen;
- a multiple of the gradient's variance nearby: motion that bends within the smallest windows.

At the rim of a mask, where windows have soil on one side only and motion is carried outwards, all of it is
taken larger.

The factors are measured, on the quick versions of `rolling_wheel`, `bucket`, `grouser_wheel`, `pushed_wheel`,
`compliant_wheel` and `fillite_wheel` and on the analytic scenes, all at seed 101, which no score uses: so
that 68 and 95 % intervals cover their shares of the true errors there.
"""

from dataclasses import dataclass

import numpy as np

from soft.flow.robust_affine.rim import shrunk
from soft.flow.robust_affine.windows import Chosen


@dataclass(frozen=True)
class Factors:
    """Of the four variances; that of the gradient's in px^2 per (px/px)^2."""

    noise: float
    excess: float
    mended: float
    gradient: float


FACTORS = {"accurate": Factors(1.25, 1.05, 0.8, 1.1), "fast": Factors(0.7, 1.0, 1.8, 17.0)}
_RIM = ((2, 1.2), (5, 1.95))
"""Factors on sigma at pixels with one outside the mask at most so many px off; both where both hold."""
_AROUND = 10.0
"""Standard deviation of the window in which the excess is averaged, px."""
_UNMEASURED = 1.0
"""Variance by noise, px^2, of windows that have hardly a pixel to use, as outside a mask."""
_NEARBY = 4.0
"""Of the one for the other two, px."""


def standard_deviation(chosen: Chosen, models: np.ndarray, preset: str) -> np.ndarray:
    """One sigma of u and of v, px: (h, w, 2) float32; `models` (h, w, 6) are those in the end."""
    mended, factors = (models - chosen.models)[:, :, ::3], FACTORS[preset]
    return np.sqrt(
        factors.noise * chosen.variance
        + factors.excess * np.maximum(_mean_excess(chosen), 0)
        + factors.mended * _averaged(mended * mended, _NEARBY / chosen.step)
        + factors.gradient * _gradient_variance(chosen.models, _NEARBY / chosen.step)[:, :, None]
    )


def widen_at_rim(sigma: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Enlarge sigma (H, W, 2) in place where a mask (H, W) bool ends nearby, and return it."""
    if not mask.all():
        for reach, factor in _RIM:
            sigma[mask & ~shrunk(mask, reach)] *= np.float32(factor)
    return sigma


def _mean_excess(chosen: Chosen) -> np.ndarray:
    """Mean excess around each place, (h, w, 2), px^2, of those alone whose windows have pixels to use.

    Where the next smaller window had none, the excess is half of its huge variance by noise, negative.
    """
    smaller = -2 * np.minimum(chosen.excess, 0)
    measured = (np.maximum(chosen.variance, smaller) < _UNMEASURED).astype(np.float32)
    sigma = _AROUND / chosen.step
    total, share = (_averaged(values, sigma) for values in (measured * chosen.excess, measured))
    return total / np.maximum(share, 1e-3)


def _gradient_variance(models: np.ndarray, sigma: float) -> np.ndarray:
    """Variance of the motion's gradient around each place, summed over its entries: (h, w), (px/px)^2."""
    gradient = np.ascontiguousarray(models[:, :, [1, 2, 4, 5]])
    mean, square = _averaged(gradient, sigma), _averaged(gradient * gradient, sigma)
    return np.maximum(square - mean * mean, 0).sum(axis=2)


def _averaged(values: np.ndarray, sigma: float) -> np.ndarray:
    import cv2

    return cv2.GaussianBlur(values, (0, 0), sigma)
