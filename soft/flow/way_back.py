"""The way back, for the forward-backward check of methods that are too slow to be asked twice."""

import numpy as np

from soft.flow.coarse_search import least_side, mismatch, search
from soft.flow.consistency import landing
from soft.flow.field import FlowField
from soft.flow.opencv import halved, to_8bit

MISSES = 2.5
"""By so much the way back may miss the start, px: near breaks of the motion, coarse search is off by one."""
QUICK_MISSES = 0.5
"""The same without a search."""
_FINEST = 1
"""Level of the halved pictures' pyramid on which the search ends."""
_BOX = 3
"""Side of the box over which grey levels are compared, px."""
_AGREEING, _SLACK = 3.0, 3.0
"""Pictures agree where they differ by at most so many times the median, and so many grey levels."""
_EVERY = 3
"""The median is that of every third pixel each way."""
_CLEARLY = 0.85
"""Where they do not, something must explain them better by this factor."""


def way_back(first: np.ndarray, second: np.ndarray, forward: FlowField, options: object) -> np.ndarray:
    """Motion from the second picture to the first, (h, w, 2) px, of every second pixel of the second each way.

    Found on pictures of half the size. A coarse search's, or the forward motion turned round where the pictures agree better under it: what is
    hidden in the second picture, or was mistaken for something else, goes another way back.

    Parameters
    ----------
    first, second : (H, W) float32
        Grey levels, 0-255.
    forward : FlowField
    options : object
        The method's own, which do not matter here.
    """
    before, after, there = _halves(first, second, forward)
    searched = np.zeros_like(there)
    if min(before.shape) >= least_side(_FINEST):
        searched = search(after, before, finest=_FINEST)
    fits = _agree(mismatch(before, after, np.nan_to_num(there), box=_BOX))
    turned = _turned(there, fits, searched)
    off = mismatch(after, before, turned, box=_BOX)
    factor = np.where(_agree(off), 1, _CLEARLY)
    right = off <= factor * mismatch(after, before, searched, box=_BOX)
    return 2 * np.where(right[:, :, None], turned, searched)


def quick_way_back(first: np.ndarray, second: np.ndarray, forward: FlowField, options: object) -> np.ndarray:
    """The forward motion turned round, on pictures of half the size, without a search.

    (h, w, 2) px, of every second pixel each way. Where several have landed, the one under whose motion the pictures agree: what is hidden lands there too,
    and is not taken back.
    """
    before, after, there = _halves(first, second, forward)
    known = np.nan_to_num(there)
    return 2 * _turned(there, _agree(mismatch(before, after, known, box=_BOX)), -known)


def _halves(
    first: np.ndarray, second: np.ndarray, forward: FlowField
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    before, after = (halved(to_8bit(grey)) for grey in (first, second))
    return before, after, forward.displacement[::2, ::2] / 2


def _agree(off: np.ndarray) -> np.ndarray:
    return off < _AGREEING * np.median(off[::_EVERY, ::_EVERY]) + _SLACK


def _turned(forward: np.ndarray, fits: np.ndarray, otherwise: np.ndarray) -> np.ndarray:
    """What moved there turned round, at the pixel where it has landed; elsewhere as told.

    Where several have landed, one under whose motion the pictures fit stands.
    """
    height, width = forward.shape[:2]
    x, y = (np.rint(place).astype(np.int32) for place in landing(forward))
    inside = (x >= 0) & (y >= 0) & (x < width) & (y < height)
    turned, place = otherwise.copy(), y * width + x
    for some in (inside & ~fits, inside & fits):
        turned.reshape(-1, 2)[place[some]] = -forward[some]
    return turned
