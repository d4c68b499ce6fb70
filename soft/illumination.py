"""Uneven light: a smooth surface through the grey levels of most of the picture, divided out."""

import numpy as np

# Side in px that pictures are reduced to for the fit: the surface has six coefficients only.
FIT_SIDE = 100
ROUNDS = 10

# Standard deviations beyond which a pixel does not belong to the surface.
OUTLIER = 2.5


def flatten_illumination(picture: np.ndarray) -> np.ndarray:
    """Grey levels over the illumination of the picture's larger part: (H, W) float32, about 1 there.

    The illumination is a quadratic surface in x and y, fitted again and again without the pixels that lie far
    off it (median absolute deviation), so that an implement much darker or lighter than the rest does not
    bend it.

    Parameters
    ----------
    picture : (H, W) float32
        Grey, 0-255.
    """
    import cv2

    height, width = picture.shape
    shrink = max(1.0, max(height, width) / FIT_SIDE)
    size = (max(1, round(width / shrink)), max(1, round(height / shrink)))
    small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    coefficients = _robust_fit(_terms(*small.shape), small.ravel())
    surface = np.zeros(picture.shape, np.float32)
    # Term by term and not as one matrix, which would be six pictures large.
    for coefficient, term in zip(coefficients, _terms(height, width), strict=True):
        surface += np.float32(coefficient) * term
    # A surface that runs to zero at a corner must not turn its grey levels to infinity.
    return picture / np.maximum(surface, np.float32(0.1) * surface.max() + np.float32(1.0))


def _terms(height: int, width: int) -> list[np.ndarray]:
    """1, x, y, x^2, x y, y^2 on a grid from -1 to 1 each way; each broadcasts to (height, width)."""
    x = np.linspace(-1, 1, width, dtype=np.float32)[None, :]
    y = np.linspace(-1, 1, height, dtype=np.float32)[:, None]
    return [np.ones((1, 1), np.float32), x, y, x * x, x * y, y * y]


def _robust_fit(terms: list[np.ndarray], grey: np.ndarray) -> np.ndarray:
    shape = np.broadcast_shapes(*(term.shape for term in terms))
    matrix = np.stack([np.broadcast_to(term, shape).ravel() for term in terms], axis=1).astype(np.float64)
    used = np.ones(grey.size, bool)
    coefficients = np.zeros(len(terms))
    for _ in range(ROUNDS):
        coefficients = np.linalg.lstsq(matrix[used], grey[used], rcond=None)[0]
        residual = np.abs(grey - matrix @ coefficients)
        limit = OUTLIER * 1.4826 * np.median(residual)
        now_used = residual <= max(limit, 1.0)
        if np.array_equal(now_used, used):
            break
        used = now_used
    return coefficients
