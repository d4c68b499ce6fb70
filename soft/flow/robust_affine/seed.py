"""The coarse field to start from.

Dense inverse search (Kroeger, Timofte, Dai, Van Gool, ECCV 2016) on coarse levels finds several px at once,
but fine grains leave little on coarse levels to hold on to. So it is also started from the shift that most of
the picture shares (phase correlation), where that is large, and each pixel takes the better of both.
"""

import numpy as np

from soft.flow.opencv import to_8bit
from soft.flow.shift import common_shift, mismatch

_PATCH = 8
_FINEST, _FINEST_BACK = 1, 2
"""Level of the pyramid on which the search ends, 1 = half resolution; and the one for the way back."""
_BOX, _BOX_BACK = 15, 5
"""Side of the box over which grey levels are compared, px; and the one for the way back."""


def seed(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Models (H, W, 6) of motion without gradients; zero on pictures too small for a pyramid."""
    models = np.zeros((*first.shape, 6), np.float32)
    if min(first.shape) >= _PATCH * 2 ** (_FINEST + 1):
        models[:, :, ::3] = _searched(to_8bit(first), to_8bit(second))
    return models


def _searched(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    found, shift = _search(first, second, _FINEST), common_shift(first, second)
    if shift is None:
        return found
    other = _search(first, _moved(second, shift), _FINEST) + shift
    return _better(first, second, (other, found), _BOX)


def way_back(first: np.ndarray, second: np.ndarray, forward: np.ndarray) -> np.ndarray:
    """Motion from the second picture to the first, (H, W, 2) px, as the forward-backward check asks for it.

    A coarse search's, or the forward motion turned round where the pictures agree better under that: what is
    hidden in the second picture, or was mistaken for something else, goes another way back.

    Parameters
    ----------
    first, second : (H, W) float32
        Grey levels, 0-255.
    forward : (H, W, 2) float32
        Px; NaN where not measured.
    """
    before, after = to_8bit(first), to_8bit(second)
    if min(first.shape) < _PATCH * 2 ** (_FINEST_BACK + 1):
        return _turned(forward, np.zeros_like(forward))
    searched = _search(after, before, _FINEST_BACK)
    return _better(after, before, (_turned(forward, searched), searched), _BOX_BACK)


def _turned(forward: np.ndarray, otherwise: np.ndarray) -> np.ndarray:
    """What moved there turned round, at the pixel where it has landed; elsewhere as told."""
    height, width = forward.shape[:2]
    rows, columns = np.nonzero(np.isfinite(forward[:, :, 0]))
    moved = forward[rows, columns]
    x, y = np.rint(columns + moved[:, 0]).astype(int), np.rint(rows + moved[:, 1]).astype(int)
    inside = (x >= 0) & (y >= 0) & (x < width) & (y < height)
    turned = otherwise.copy()
    turned[y[inside], x[inside]] = -moved[inside]
    return turned


def _better(
    first: np.ndarray, second: np.ndarray, motions: tuple[np.ndarray, np.ndarray], box: int
) -> np.ndarray:
    """The one of two motions under which the pictures agree better; the latter where it makes no odds."""
    one, other = (mismatch(first, second, motion, box=box) for motion in motions)
    return np.where((one < other)[:, :, None], *motions)


def _search(first: np.ndarray, second: np.ndarray, finest: int) -> np.ndarray:
    import cv2

    solver = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    solver.setFinestScale(finest)
    return solver.calc(first, second, None)  # type: ignore[call-overload, no-any-return]


def _moved(picture: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """What lies at x + shift, at x."""
    import cv2

    height, width = picture.shape
    matrix = np.array([[1, 0, shift[0]], [0, 1, shift[1]]], np.float32)
    flags = cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(picture, matrix, (width, height), flags=flags, borderMode=cv2.BORDER_REPLICATE)
