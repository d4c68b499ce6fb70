"""How sure: noise of the pictures, and motion that an affine window cannot follow.

Three variances add up:

- noise, as propagated through the fit (`windows.Fit.variance`);
- what the smallest window finds otherwise than the chosen one, beyond noise: at a single pixel too little to
  be told from noise, but its mean square around a pixel is (large at breaks of the motion);
- what neither follows: proportional to how much the motion's gradient varies nearby, plus a floor for the
  pictures' own sampling.

The last two numbers are measured, on the quick versions of `rolling_wheel` and `bucket` at seed 101, which
no score uses: so that 68 and 95 % intervals cover their shares of the true errors there.
"""

import numpy as np

from soft.flow.robust_affine.brightness import averaged_small
from soft.flow.robust_affine.windows import Chosen

_AROUND = 10.0
"""Standard deviation of the window in which differences between fits are averaged, px."""
_NEARBY = 8.0
"""Of the one in which the gradient's variation is, px."""
_SHRINK = 4
_REACH = 1.3
"""Error by uneven gradients / their standard deviation, px per px/px."""
_FLOOR = 0.0105
"""px."""


def standard_deviation(chosen: Chosen) -> np.ndarray:
    """One sigma of u and of v, px: (H, W, 2) float32."""
    difference = chosen.models[:, :, ::3] - chosen.smallest
    # The chosen fit shares the smallest one's data: their difference varies by the difference of variances.
    excess = difference * difference - np.maximum(chosen.smallest_variance - chosen.variance, 0)
    finer = np.maximum(_averaged(excess, _AROUND), 0)
    unresolved = _REACH**2 * _gradient_variance(chosen.models) + _FLOOR**2
    return np.sqrt(chosen.variance + finer + unresolved[:, :, None])


def _gradient_variance(models: np.ndarray) -> np.ndarray:
    """Variance of the motion's gradient around each pixel, summed over its entries: (H, W), (px/px)^2."""
    gradient = np.ascontiguousarray(models[:, :, [1, 2, 4, 5]])
    mean, square = _averaged(gradient, _NEARBY), _averaged(gradient * gradient, _NEARBY)
    return np.maximum(square - mean * mean, 0).sum(axis=2)


def _averaged(values: np.ndarray, sigma: float) -> np.ndarray:
    """Gaussian average around each pixel, by way of a smaller picture."""
    import cv2

    height, width = values.shape[:2]
    return cv2.resize(averaged_small(values, sigma, _SHRINK), (width, height))
