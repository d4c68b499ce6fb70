"""The shift that most of a picture shares, and how well a motion explains two pictures."""

import numpy as np

LARGE = 8.0
"""A common shift beyond this is worth a start of its own, px."""
_CLEAR = 0.25
"""Height of the phase correlation's peak from which on most of the picture shares a shift."""


def common_shift(first: np.ndarray, second: np.ndarray) -> np.ndarray | None:
    """Shift from the first to the second picture, whole px (x, y) float32; None unless clear and large.

    By phase correlation of pictures of half the size, faded out towards their border (Hann window): borders
    that do not match their opposites would hide the shift.
    """
    import cv2

    halves = [
        cv2.resize(grey, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA) for grey in (first, second)
    ]
    height, width = halves[0].shape
    window = cv2.createHanningWindow((width, height), cv2.CV_32F)
    half, peak = cv2.phaseCorrelate(*(grey.astype(np.float32) for grey in halves), window)
    shift = np.rint(2 * np.array(half)).astype(np.float32)
    return shift if peak > _CLEAR and np.hypot(*shift) > LARGE else None


def mismatch(first: np.ndarray, second: np.ndarray, motion: np.ndarray, *, box: int = 15) -> np.ndarray:
    """Mean difference of grey levels in a box around each pixel, if it moves so: (H, W) float32."""
    import cv2

    height, width = first.shape
    x = np.arange(width, dtype=np.float32) + motion[:, :, 0]
    y = np.arange(height, dtype=np.float32)[:, None] + motion[:, :, 1]
    there = cv2.remap(second, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return cv2.boxFilter(cv2.absdiff(first, there), cv2.CV_32F, (box, box))


def _half(grey: np.ndarray) -> np.ndarray:
    import cv2

    return cv2.resize(grey, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
