"""The coarse field to start from.

Dense inverse search (Kroeger, Timofte, Dai, Van Gool, ECCV 2016) on coarse levels finds several px at once,
but fine grains leave little on coarse levels to hold on to. So it is also started from the shift that most of
the picture shares (phase correlation), where that is large, and each pixel takes the better of both.
"""

import numpy as np

from soft.flow.coarse_search import LARGE, better_of, common_shift, least_side, search
from soft.flow.opencv import halved, to_8bit

_QUARTER = np.array([1 / 4, 3 / 4, 0], np.float32)
"""Weights of a pixel's neighbour before it and of itself, for what lies a quarter of a pixel before it."""


def seed(first: np.ndarray, second: np.ndarray, *, quick: bool) -> np.ndarray:
    """Motion without gradients: models of every second pixel each way, found on pictures of half the size.

    (h, w, 6) float32, in px of the pictures given; zero on pictures too small for a pyramid.
    """
    before, after = (halved(to_8bit(picture)) for picture in (first, second))
    models = np.zeros((*before.shape, 6), np.float32)
    if min(before.shape) >= least_side(0):
        found = _searched(before, after, quick)
        # Averaging calms what noise makes of it; `fast` mends no break afterwards and does better without.
        models[:, :, ::3] = 2 * (found if quick else _at_pixels(found))
    return models


def _at_pixels(motion: np.ndarray) -> np.ndarray:
    """At the pictures' second pixels: a quarter of a halved one's pixel up and to the left of its own."""
    import cv2

    return cv2.sepFilter2D(motion, -1, _QUARTER, _QUARTER, borderType=cv2.BORDER_REPLICATE)


def _searched(first: np.ndarray, second: np.ndarray, quick: bool) -> np.ndarray:
    found = search(first, second, finest=0, quick=quick)
    shift = common_shift(first, second, large=LARGE / 2)
    if shift is None:
        return found
    other = search(first, _moved(second, shift), finest=0, quick=quick) + shift
    return better_of(first, second, other, found, box=7)


def _moved(picture: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """What lies at x + shift, at x."""
    import cv2

    height, width = picture.shape
    matrix = np.array([[1, 0, shift[0]], [0, 1, shift[1]]], np.float32)
    flags = cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(picture, matrix, (width, height), flags=flags, borderMode=cv2.BORDER_REPLICATE)
