"""How sure: noise of the pictures, and motion that an affine window cannot follow.

Four variances add up:

- noise, as propagated through the fit (`windows.Fit.variance`);
- a share of what the next smaller window finds otherwise, beyond noise: at a single place too little to be
  told from noise, but its mean around a place is;
- a multiple of what was mended after windows were chosen;
- a multiple of the gradient's variance nearby: motion that bends within the smallest windows.

At the rim of a mask, where windows have soil on one side only and motion is carried outwards, all of it is
taken larger.

The factors depend on the window that was chosen: a small one was taken because larger ones disagree, so its
own noise says too little; a large one's errors are those of motion that bends within it. They are measured
at seed 101, which no score uses, on the quick versions of `rolling_wheel`, `grouser_wheel` and
`compliant_wheel`, on two wheels in sands with grains between GRC-1's and Fillite's, and on the analytic
scenes: so that 68 and 95 % intervals cover their shares of the true errors there. Those of `fast` are the
same for all of its windows.
"""

from dataclasses import dataclass

import numpy as np

from soft.flow.robust_affine.rim import shrunk
from soft.flow.robust_affine.windows import Chosen


@dataclass(frozen=True)
class Factors:
    """Of the four variances, by window from the smallest on; the gradient's in px^2 per (px/px)^2."""

    noise: tuple[float, ...]
    excess: tuple[float, ...]
    mended: float
    gradient: tuple[float, ...]


FACTORS = {
    "accurate": Factors(
        noise=(2.8, 2.8, 2.0, 2.0, 1.1),
        excess=(2.3, 2.3, 4.7, 4.7, 0.6),
        mended=0.05,
        gradient=5 * (0.0,),
    ),
    "fast": Factors(
        noise=(0.03, 0.47, 0.31), excess=(0.0, 0.0, 0.67), mended=0.0, gradient=(2.2, 11.0, 436.0)
    ),
}
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
    level = np.maximum(chosen.level, 0)
    noise, excess, gradient = (
        np.array(by_window, np.float32)[level][:, :, None]
        for by_window in (factors.noise, factors.excess, factors.gradient)
    )
    return np.sqrt(
        noise * chosen.variance
        + excess * np.maximum(_mean_excess(chosen), 0)
        + factors.mended * _averaged(mended * mended, _NEARBY / chosen.step)
        + gradient * _gradient_variance(chosen.models, _NEARBY / chosen.step)[:, :, None]
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
