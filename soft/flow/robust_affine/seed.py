"""The coarse field to start from.

Dense inverse search (Kroeger, Timofte, Dai, Van Gool, ECCV 2016) on coarse levels finds several px at once,
but fine grains leave little on coarse levels to hold on to. So it is also started from the shift that most of
the picture shares (phase correlation), where that is large, and each pixel takes the better of both.
"""

import numpy as np

from soft.flow.coarse_search import better_of, common_shift, least_side, search
from soft.flow.opencv import to_8bit

_FINEST = 1
"""Level of the pyramid on which the search ends: 1 = half resolution."""


def seed(first: np.ndarray, second: np.ndarray, *, quick: bool) -> np.ndarray:
    """Models (H, W, 6) of motion without gradients; zero on pictures too small for a pyramid."""
    models = np.zeros((*first.shape, 6), np.float32)
    if min(first.shape) >= least_side(_FINEST):
        models[:, :, ::3] = _searched(to_8bit(first), to_8bit(second), quick)
    return models


def _searched(first: np.ndarray, second: np.ndarray, quick: bool) -> np.ndarray:
    found = search(first, second, finest=_FINEST, quick=quick)
    shift = common_shift(first, second)
    if shift is None:
        return found
    other = search(first, _moved(second, shift), finest=_FINEST, quick=quick) + shift
    return better_of(first, second, other, found)


def _moved(picture: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """What lies at x + shift, at x."""
    import cv2

    height, width = picture.shape
    matrix = np.array([[1, 0, shift[0]], [0, 1, shift[1]]], np.float32)
    flags = cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(picture, matrix, (width, height), flags=flags, borderMode=cv2.BORDER_REPLICATE)
