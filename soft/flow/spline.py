"""Pictures as cubic B-splines (Unser, Aldroubi, Eden, IEEE Trans. Signal Processing 41, 1993)."""

import numpy as np

_POLE = np.sqrt(3.0) - 2.0
"""Of the inverse filter."""
_REACH = 12
"""Coefficients of it that are kept each way: the next is below 1e-7 of the first."""
_INVERSE = (np.sqrt(3.0) * _POLE ** np.abs(np.arange(-_REACH, _REACH + 1))).astype(np.float32)
_SMOOTH = np.array([1 / 6, 2 / 3, 1 / 6], np.float32)
_SLOPE = np.array([-1 / 2, 0, 1 / 2], np.float32)


def spline_coefficients(picture: np.ndarray) -> np.ndarray:
    """Coefficients of the spline through a picture's grey levels, mirrored at its border: (H, W) float32."""
    return _filtered(picture, _INVERSE, _INVERSE)


def grey_and_slopes(picture: np.ndarray) -> np.ndarray:
    """Grey level of every pixel and its slopes along x and y, those of the spline: (H, W, 3) float32."""
    import cv2

    own = spline_coefficients(picture)
    return cv2.merge([picture, _filtered(own, _SLOPE, _SMOOTH), _filtered(own, _SMOOTH, _SLOPE)])


def _filtered(picture: np.ndarray, along_x: np.ndarray, along_y: np.ndarray) -> np.ndarray:
    import cv2

    return cv2.sepFilter2D(picture, cv2.CV_32F, along_x, along_y, borderType=cv2.BORDER_REFLECT_101)
