"""How sure: noise of the pictures, and motion that an affine window cannot follow.

Five variances add up. The first three are in units of the noise as propagated through the fit
(`windows.Fit.variance`), the last two are measured:

- noise itself, little of it, for the next part holds most;
- motion hidden below noise: a window is enlarged as long as it smoothes away no more than the noise it saves.
  How much of that there is to hide is told by how the motion's gradient varies around, against what noise
  makes of it: least where a picture turns, shifts or strains as a whole;
- where noise matters in the slopes (`brightness`), more, by how much it does: fine soil, whose texture is
  hardly wider than a pixel, hides more;
- a share of what the next smaller window finds otherwise, beyond noise: at a single place too little to be
  told from noise, but its mean around a place is;
- a share of what was mended after windows were chosen.

At the rim of a mask, where windows have soil on one side only and motion is carried outwards, all of it is
taken larger.

The factors depend on the window that was chosen. They are measured at seed 101, which no score uses, on the
quick versions of `rolling_wheel`, `grouser_wheel`, `pushed_wheel`, `compliant_wheel`, `bucket` and
`fillite_wheel`, on two wheels in sands with grains between GRC-1's and Fillite's, and on the analytic scenes,
as they are and with the severity `paper`'s noise, the largest windows' also on `fillite_wheel` at seed 102:
so that 68 and 95 % intervals cover their shares of the true errors there.
"""

from dataclasses import dataclass

import numpy as np

from soft.flow.robust_affine.rim import DOUBTFUL, shrunk
from soft.flow.robust_affine.windows import Chosen


@dataclass(frozen=True)
class Factors:
    """Of the variances, by window from the smallest on."""

    hidden: tuple[float, ...]
    stretched: tuple[float, ...]
    excess: tuple[float, ...]
    mended: tuple[float, ...]


FACTORS = {
    "accurate": Factors(
        hidden=(3.05, 3.05, 2.55, 2.55, 2.0),
        stretched=(0.0, 0.0, 4.0, 4.0, 1.7),
        excess=(2.7, 2.7, 2.25, 2.25, 0.0),
        mended=(0.52, 0.52, 0.37, 0.37, 0.37),
    ),
    "fast": Factors(
        hidden=(2.05, 2.8, 2.4), stretched=(0.55, 3.9, 0.85), excess=(0.13, 2.9, 0.0), mended=(0.0, 0.0, 0.0)
    ),
}
_NOISE = 0.1
"""Share of the noise that is counted anywhere."""
_HALF_HIDDEN = 3.0
"""Half of what noise may hide is there where gradients vary by so many times noise / window size squared."""
_AT_RIM = 1.6
"""Factor on sigma within `DOUBTFUL` px of a mask's end."""
_AROUND = 10.0
"""Standard deviation of the window in which the excess is averaged, px."""
_UNMEASURED = 1.0
"""Variance by noise, px^2, of windows that have hardly a pixel to use, as outside a mask."""
_NEARBY = 4.0
"""Of the one for what was mended, and for how gradients vary, px,"""
_FAR, _LARGE = 16.0, 10.0
"""but this one where windows are larger than that, px."""
_SHRINK = 4
"""The latter is found on every fourth place each way."""
_TINY = 1e-12
"""(px/px)^2."""


def standard_deviation(chosen: Chosen, models: np.ndarray, preset: str, stretch: float) -> np.ndarray:
    """One sigma of u and of v, px: (h, w, 2) float32.

    Parameters
    ----------
    chosen : Chosen
    models : (h, w, 6) float32
        Those in the end.
    preset : str
    stretch : float
        Of the pictures, see `brightness.PicturePair`.
    """
    factors, level = FACTORS[preset], np.maximum(chosen.level, 0)

    def told(by_window: tuple[float, ...]) -> np.ndarray:
        return np.array(by_window, np.float32)[level]

    by_noise = _NOISE + told(factors.hidden) * _bending(chosen, told(chosen.sizes))
    by_noise += (stretch - 1) * told(factors.stretched)
    variance = by_noise[:, :, None] * chosen.variance
    variance += told(factors.excess)[:, :, None] * np.maximum(_mean_excess(chosen), 0)
    if any(factors.mended):
        mended = (models - chosen.models)[:, :, ::3]
        variance += told(factors.mended)[:, :, None] * _averaged(mended * mended, _NEARBY / chosen.step)
    return np.sqrt(variance)


def widen_at_rim(sigma: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Enlarge sigma (H, W, 2) in place where a mask (H, W) bool ends nearby, and return it."""
    if not mask.all():
        sigma[mask & ~shrunk(mask, DOUBTFUL)] *= np.float32(_AT_RIM)
    return sigma


def _bending(chosen: Chosen, size: np.ndarray) -> np.ndarray:
    """How much of what the motion's gradient varies by around each place is more than noise: (h, w), 0 to 1.

    `size` (h, w) is the windows' standard deviation, px.
    """
    import cv2

    gradient = np.ascontiguousarray(chosen.models[:, :, [1, 2, 4, 5]])
    thin = np.ascontiguousarray(gradient[::_SHRINK, ::_SHRINK])
    far = _variation(thin, _FAR / (chosen.step * _SHRINK))
    far = cv2.resize(far, size.shape[::-1], interpolation=cv2.INTER_LINEAR)
    varies = np.where(size > _LARGE, far, _variation(gradient, _NEARBY / chosen.step))
    by_noise = chosen.variance.mean(axis=2) / (size * size)
    return varies / (varies + _HALF_HIDDEN * by_noise + _TINY)


def _variation(gradient: np.ndarray, sigma: float) -> np.ndarray:
    """Variance of (h, w, 4) gradients around each place, summed over their entries: (h, w), (px/px)^2."""
    mean, square = _averaged(gradient, sigma), _averaged(gradient * gradient, sigma)
    return np.maximum(square - mean * mean, 0).sum(axis=2)


def _mean_excess(chosen: Chosen) -> np.ndarray:
    """Mean excess around each place, (h, w, 2), px^2, of those alone whose windows have pixels to use.

    Where the next smaller window had none, the excess is half of its huge variance by noise, negative.
    """
    smaller = -2 * np.minimum(chosen.excess, 0)
    measured = (np.maximum(chosen.variance, smaller) < _UNMEASURED).astype(np.float32)
    sigma = _AROUND / chosen.step
    total, share = (_averaged(values, sigma) for values in (measured * chosen.excess, measured))
    return total / np.maximum(share, 1e-3)


def _averaged(values: np.ndarray, sigma: float) -> np.ndarray:
    import cv2

    return cv2.GaussianBlur(values, (0, 0), sigma)
