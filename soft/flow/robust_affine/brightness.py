"""Two pictures as brightness constraints: one linear equation a pixel for its motion (the paper's Eq. 3).

Grey levels between pixels come from cubic B-splines; the slopes are the mean of both pictures', which makes
the linear equation right to second order in what is left of the motion. Uneven and changing light is met by
a factor and an offset of the second picture, smooth over `LIGHT_SCALE` px.

Noise in the slopes is taken for texture, and draws fits towards the motion they start from, by the share that
it has in the slopes' squares: the one that the two pictures' slopes have not in common. Where it matters,
pictures are smoothed a little, and residuals stretched by what is left of it.
"""

from dataclasses import dataclass, replace

import numpy as np

from soft.flow.spline import grey_and_slopes, spline_coefficients

LIGHT_SCALE = 15.0
"""Standard deviation of the window in which both pictures get the same mean and contrast, px."""
_LIGHT_SHRINK = 4
"""Pictures are reduced by this for it."""
_EVERY = 5
"""Noise is told from every fifth pixel each way."""
_NOISY = 1.15
"""Mean square of the slopes / their noise-free part, from which on noise matters."""
_SAMPLED = 2
"""It is looked for at every second one of the pixels whose motion is known, each way."""
_SMOOTHING = 0.5
"""Pictures are smoothed by a Gaussian of this standard deviation then, px."""


@dataclass(frozen=True, eq=False)
class PicturePair:
    """Both pictures, made ready.

    Attributes
    ----------
    first : (h, w, 3) float32
        Grey level of the first picture and its slopes along x and y, at every `step`-th pixel each way.
    coefficients : (H, W) float32
        Of the second picture's B-spline.
    usable : (h, w) float32
        1 where a pixel of the first may be used, else 0.
    step : int
    stretch : float
        Mean square of the slopes / their noise-free part: see above.
    correlation : float
        How much more noise there is in sums of slope times noise than if pixels' were independent, as
        variance: smoothing makes neighbours' alike.
    """

    first: np.ndarray
    coefficients: np.ndarray
    usable: np.ndarray
    step: int = 1
    stretch: float = 1.0
    correlation: float = 1.0

    @classmethod
    def of(cls, first: np.ndarray, second: np.ndarray, mask: np.ndarray) -> "PicturePair":
        """From (H, W) float32 pictures and a bool mask, True = use."""
        return cls(grey_and_slopes(first), spline_coefficients(second), mask.astype(np.float32))

    def calmed(self, first: np.ndarray, second: np.ndarray, motion: np.ndarray, step: int) -> "PicturePair":
        """The pair itself or, where noise matters, one made anew of the two pictures that it was made of.

        Noise is met as it is found with models (h, w, 6) of every `step`-th pixel's motion.
        """
        some = np.ascontiguousarray(motion[::_SAMPLED, ::_SAMPLED])
        if self.thinned(step * _SAMPLED)._slope_noise(some) < _NOISY:
            return self
        pair = PicturePair.of(_smoothed(first), _smoothed(second), self.usable > 0)
        stretch = pair.thinned(step * _SAMPLED)._slope_noise(some)
        return replace(pair, stretch=stretch, correlation=pair._correlation())

    def thinned(self, step: int) -> "PicturePair":
        """With equations of every `step`-th pixel each way only, too far apart for smoothing to matter."""
        some = (slice(None, None, step), slice(None, None, step))
        first, usable = np.ascontiguousarray(self.first[some]), np.ascontiguousarray(self.usable[some])
        return replace(self, first=first, usable=usable, step=step, correlation=1.0)

    def only(self, mask: np.ndarray) -> "PicturePair":
        """With fewer pixels to use: those of a (h, w) bool mask."""
        return replace(self, usable=self.usable * mask)

    @property
    def noisy(self) -> bool:
        """Whether noise matters."""
        return self.stretch > 1

    @property
    def shape(self) -> tuple[int, int]:
        """Lines and columns of equations."""
        return self.usable.shape  # type: ignore[return-value]

    def constrain(self, models: np.ndarray) -> "Constraints":
        """Every pixel's equation, linear around where its model (H, W, 6) takes it."""
        from soft.flow.robust_affine import brightness_kernels as kernels
        from soft.flow.spline_kernels import warp

        warped = np.empty((*self.shape, 4), np.float32)
        warp(self.coefficients, self.step, models, 3, warped)
        gain = _gain(self.first[:, :, 0], warped[:, :, 0], self.usable * warped[:, :, 3], self.step)
        values = np.empty((*self.shape, 7), np.float32)
        kernels.constrain(self.first, warped, gain, models, self.usable, self.step, self.stretch, values)
        return Constraints(values, gain, self.step, self.stretch)

    def constrain_again(self, constraints: "Constraints", models: np.ndarray, places: np.ndarray) -> None:
        """Renew the equations of some places, rows and columns (P, 2) int32, whose models are others now."""
        from soft.flow.robust_affine import brightness_kernels as kernels

        kernels.constrain_places(
            places, self.coefficients, self.first, constraints.gain, models, self.usable, self.stretch,
            constraints.values,
        )  # fmt: skip

    def _slope_noise(self, models: np.ndarray) -> float:
        """Mean square of the slopes used / their noise-free part, which both pictures share; at least 1."""
        from soft.flow.spline_kernels import warp

        warped = np.empty((*self.shape, 4), np.float32)
        warp(self.coefficients, self.step, models, 3, warped)
        use = self.usable * warped[:, :, 3] > 0
        before, after = self.first[:, :, 1:][use], warped[:, :, 1:3][use]
        shared = float(np.vdot(before, after)) if use.any() else 0.0
        mean = before + after
        return max(1.0, float(np.vdot(mean, mean)) / 4 / shared) if shared > 0 else 1.0

    def _correlation(self) -> float:
        use = self.usable > 0
        point = np.zeros((9, 9), np.float32)
        point[4, 4] = 1
        alone = float(np.square(_smoothed(point)).sum())
        slopes = self.first[:, :, 1:]
        own = float(np.square(slopes[use]).sum())
        return float(np.square(_smoothed(slopes)[use]).sum()) / own / alone if own > 0 else 1.0


@dataclass(frozen=True, eq=False)
class Constraints:
    """One equation a pixel, ``jx u + jy v = d``.

    Attributes
    ----------
    values : (H, W, 7) float32
        jx, jy, d, weight (0: not usable), the residual in grey levels, and what noise alone makes of jx and
        jy times the residual on average, over the residual's variance.
    gain : (H, W, 2) float32
        Factor and offset of the second picture.
    step : int
        From pixel to pixel, px.
    stretch : float
        Of the residuals in d.
    """

    values: np.ndarray
    gain: np.ndarray
    step: int
    stretch: float

    def noise(self) -> float:
        """Standard deviation of the residuals, grey levels, from their median: outliers do not count."""
        some = self.values[::_EVERY, ::_EVERY]
        residual = np.abs(some[:, :, 4][some[:, :, 3] > 0])
        return 1.4826 * float(np.median(residual)) + 1e-3 if residual.size else 1.0


def _smoothed(values: np.ndarray) -> np.ndarray:
    import cv2

    return cv2.GaussianBlur(values, (0, 0), _SMOOTHING)


def averaged_small(values: np.ndarray, sigma: float, shrink: int) -> np.ndarray:
    """Gaussian averages, `sigma` px wide, of (H, W[, C]) values, in a picture `shrink` times smaller."""
    import cv2

    height, width = values.shape[:2]
    size = (max(1, width // shrink), max(1, height // shrink))
    small = cv2.resize(values, size, interpolation=cv2.INTER_AREA)
    return cv2.GaussianBlur(small, (0, 0), sigma / shrink)


def _gain(first: np.ndarray, second: np.ndarray, weight: np.ndarray, step: int) -> np.ndarray:
    """Factor and offset (h, w, 2) that give the second picture the first one's local mean and contrast."""
    import cv2

    height, width = first.shape
    shrink = max(1, _LIGHT_SHRINK // step)

    def mean_of(values: np.ndarray) -> np.ndarray:
        return averaged_small(weight * values, LIGHT_SCALE / step, shrink) / share

    share = averaged_small(weight, LIGHT_SCALE / step, shrink) + 1e-6
    mean, mean_after = mean_of(first), mean_of(second)
    contrast = mean_of(first * first) - mean * mean
    contrast_after = mean_of(second * second) - mean_after * mean_after
    factor = np.sqrt(np.maximum(contrast, 1.0) / np.maximum(contrast_after, 1.0))
    lit = np.dstack([factor, mean - factor * mean_after])
    return cv2.resize(lit, (width, height), interpolation=cv2.INTER_LINEAR)
