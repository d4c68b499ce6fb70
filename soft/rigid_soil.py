"""How much the soil around each pixel tells of the camera: the less it deforms, the more.

Soil that rests does not deform. Soil that gives way under a wheel does, and the further from where it rests
the more it has moved: by its gradient times the way. So the variance of what it says of the camera grows with
the square of its gradient, and each pixel counts by the inverse of that.
"""

import numpy as np

SCALE = 10.0
"""Px, standard deviation of the Gaussian that motion is smoothed with before its gradient is taken: wide
enough for errors of flow, narrow against a moving mass."""

_RIGID_SHARE = 0.1
"""Of the soil: the gradient below which this much of it lies is not told apart from none."""

_LEAST_COVER = 0.9
"""Of the smoothing window within soil: nearer to its outline, a gradient may be the implement's."""

_LEAST_GRADIENT = 1e-6
"""px/px."""


def rigidity(displacement: np.ndarray, soil: np.ndarray) -> np.ndarray:
    """Weights of pixels in a mean of the camera's motion, (H, W) float32 from 0 to 1.

    Parameters
    ----------
    displacement : (H, W, 2) array
        In px; NaN where it was not measured. Of a grid the nodes alone are, and smoothed over so much more.
    soil : (H, W) bool
        Where soil is.

    Returns
    -------
    (H, W) float32
        0 where nothing was measured, and near the soil's outline.
    """
    known = soil & np.isfinite(displacement).all(axis=2)
    weights = np.zeros(soil.shape, np.float32)
    if not known.any():
        return weights
    gradient, counted = _gradient(displacement, known, soil)
    if not counted.any():
        return known.astype(np.float32)
    rigid = max(float(np.quantile(gradient[counted], _RIGID_SHARE)), _LEAST_GRADIENT)
    weights[counted] = 1 / (1 + np.square(gradient[counted] / rigid))
    return weights


def _gradient(displacement: np.ndarray, known: np.ndarray, soil: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Frobenius norm of the smoothed motion's gradient, px/px, and where it is known: (H, W) each."""
    import cv2

    # About how far a grid's nodes are apart; 1 px where every pixel was measured.
    scale = max(SCALE, float(np.sqrt(soil.sum() / known.sum())))

    def smooth(values: np.ndarray) -> np.ndarray:
        return np.asarray(cv2.GaussianBlur(values.astype(np.float32), (0, 0), scale))

    near, cover = smooth(known), smooth(soil)
    squares = np.zeros(soil.shape, np.float32)
    for component in np.moveaxis(displacement, 2, 0):
        mean = smooth(np.where(known, component, 0.0)) / np.maximum(near, np.finfo(np.float32).tiny)
        for part in np.gradient(mean):
            squares += np.square(part)
    return np.sqrt(squares), known & (cover >= _LEAST_COVER)
