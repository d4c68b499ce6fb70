"""The Cramér-Rao bound of an affine window: how sure of a motion two noisy pictures can be.

A window's pixels move by an affine motion, six unknowns; what the pictures would show without noise is not
known either. Every pixel has a grey level f of its own, seen in the first picture with noise of variance s1^2
and in the second as g f with s2^2 (g: change of light). The information on the motion that is left once f is
free is J J^T / (s1^2 + s2^2 / g^2), J the slopes of f: the variance is that of the *difference* of both
pictures, 2 s^2 under steady light. That slopes may be taken from both pictures does not lower it: their own
noise enters in second order only. Rounding to whole grey levels counts as noise of variance 1/12. That g and
an offset have to be found as well is left out, as is what interpolation does: a bound all the same.

No unbiased fit in the window has a smaller variance (Kay, *Fundamentals of Statistical Signal Processing*,
vol. 1, 1993, ch. 3). A method that averages over more pixels may come below the bound of a small window.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from synth.scene import AnalyticScene

SIDES = (31, 101)
"""Of square windows, px: the usual large subset of image correlation, and all that the largest window of
`robust-affine` reaches (2.5 times 20 px each way)."""
_ROUNDING = 1 / 12
"""Variance of rounding to whole grey levels."""
_STEP = 1e-3
"""px; over which slopes are taken."""
MEDIAN, PERCENT_95 = np.sqrt(np.log(2.0)), np.sqrt(np.log(20.0))
"""Of the end-point error / its root mean square, where both components are normal and alike (Rayleigh)."""


@dataclass(frozen=True)
class Bound:
    """Least root mean square end-point error at the middle of windows.

    Attributes
    ----------
    side : int
        Of the windows, px.
    rms : float
        px; the median over the picture.
    """

    side: int
    rms: float

    @property
    def median(self) -> float:
        """Median end-point error of normal errors at the bound, px."""
        return float(MEDIAN * self.rms)

    @property
    def p95(self) -> float:
        """Their 95 % end-point error, px."""
        return float(PERCENT_95 * self.rms)


def scene_bounds(scene: "AnalyticScene", places: np.ndarray, sides: tuple[int, ...] = SIDES) -> list[Bound]:
    """Bounds at places (P, 2), rows and columns, of a scene's first picture."""
    slopes, variance = true_slopes(scene), difference_variance(scene)
    return [
        Bound(side, float(np.median([_rms(slopes, variance, side, *place) for place in places])))
        for side in sides
    ]


def difference_variance(scene: "AnalyticScene") -> float:
    """Variance of a pixel's difference between both pictures, under the first one's light; grey levels^2."""
    each = scene.sensor.noise**2 + (_ROUNDING if scene.sensor.bits == 8 else 0.0)
    return float(each * (1 + 1 / scene.sensor.gain**2))


def true_slopes(scene: "AnalyticScene") -> np.ndarray:
    """Slopes of the first picture's light along x and y, grey levels a px: (H, W, 2)."""
    from synth.analytic.motion import Translation
    from synth.analytic.picture import light_of, strew

    grains, slopes = strew(scene), []
    for u, v in ((_STEP, 0.0), (0.0, _STEP)):
        nudged = scene.model_copy(update={"motion": Translation(kind="translation", u=u, v=v)})
        # What lay at x - u, at x: the light moves, not the place where it is read.
        slopes.append((light_of(nudged, grains, -1) - light_of(nudged, grains, 1)) / (2 * _STEP))
    return np.stack(slopes, axis=-1)


def affine_covariance(slopes: np.ndarray, variance: float, row: int, column: int) -> np.ndarray:
    """Least covariance (6, 6) of (u, ux, uy, v, vx, vy) at a place of a window, px and px/px.

    Parameters
    ----------
    slopes : (h, w, 2) array
        Of the window's pixels.
    variance : float
        Of the difference of both pictures at a pixel, grey levels squared.
    row, column : int
        The place.
    """
    y, x = np.mgrid[: slopes.shape[0], : slopes.shape[1]].reshape(2, -1) - np.array([[row], [column]])
    jx, jy = slopes.reshape(-1, 2).T
    design = np.stack([jx, jx * x, jx * y, jy, jy * x, jy * y], axis=1)
    return np.linalg.inv(design.T @ design) * variance


def _rms(slopes: np.ndarray, variance: float, side: int, row: int, column: int) -> float:
    top, left = max(0, row - side // 2), max(0, column - side // 2)
    window = slopes[top : row + side // 2 + 1, left : column + side // 2 + 1]
    covariance = affine_covariance(window, variance, row - top, column - left)
    return float(np.sqrt(covariance[0, 0] + covariance[3, 3]))
