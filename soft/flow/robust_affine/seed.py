"""The coarse field to start from.

Dense inverse search (Kroeger, Timofte, Dai, Van Gool, ECCV 2016) on coarse levels finds several px at once,
but fine grains leave little on coarse levels to hold on to. So it is also started from the shift that most of
the picture shares (phase correlation), where that is large, and each pixel takes the better of both.
"""

import numpy as np

from soft.flow.opencv import to_8bit

_PATCH = 8
_FINEST = 1
"""Level of the pyramid on which the search ends: 1 = half resolution."""
_LARGE = 8.0
"""A common shift beyond this is worth a second search, px."""
_CLEAR = 0.3
"""Height of the phase correlation's peak from which on most of the picture shares a shift."""
_BOX = 15
"""Side of the box over which grey levels are compared, px."""


def seed(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Models (H, W, 6) of motion without gradients; zero on pictures too small for a pyramid."""
    models = np.zeros((*first.shape, 6), np.float32)
    if min(first.shape) >= _PATCH * 2 ** (_FINEST + 1):
        models[:, :, ::3] = _searched(to_8bit(first), to_8bit(second))
    return models


def _searched(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    found, shift = _search(first, second), _common_shift(first, second)
    if np.hypot(*shift) <= _LARGE:
        return found
    other = _search(first, _moved(second, shift)) + shift
    better = _mismatch(first, second, other) < _mismatch(first, second, found)
    return np.where(better[:, :, None], other, found)


def _common_shift(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Whole px (x, y) that most of the picture moves by; zero where no motion is shared."""
    import cv2

    half = [
        cv2.resize(picture, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA) for picture in (first, second)
    ]
    shift, peak = cv2.phaseCorrelate(*(picture.astype(np.float32) for picture in half))
    return np.rint(2 * np.array(shift) if peak > _CLEAR else np.zeros(2)).astype(np.float32)


def _search(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    import cv2

    solver = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    solver.setFinestScale(_FINEST)
    return solver.calc(first, second, None)  # type: ignore[call-overload, no-any-return]


def _moved(picture: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """What lies at x + shift, at x."""
    import cv2

    height, width = picture.shape
    matrix = np.array([[1, 0, shift[0]], [0, 1, shift[1]]], np.float32)
    flags = cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(picture, matrix, (width, height), flags=flags, borderMode=cv2.BORDER_REPLICATE)


def _mismatch(first: np.ndarray, second: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """Mean difference of grey levels around each pixel, if it moves so."""
    import cv2

    height, width = first.shape
    x = np.arange(width, dtype=np.float32) + motion[:, :, 0]
    y = np.arange(height, dtype=np.float32)[:, None] + motion[:, :, 1]
    there = cv2.remap(second, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return cv2.boxFilter(cv2.absdiff(first, there), cv2.CV_32F, (_BOX, _BOX))
