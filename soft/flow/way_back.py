"""The way back, for the forward-backward check of methods that are too slow to be asked twice."""

import numpy as np

from soft.flow.coarse_search import least_side, mismatch, search
from soft.flow.consistency import landing
from soft.flow.field import FlowField, known
from soft.flow.opencv import halved, to_8bit
from soft.growth import grown

MISSES = 2.0
"""By so much the way back may miss the start, px: near breaks of the motion, coarse search is off by one."""
QUICK_MISSES = 0.4
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
    """Motion from the second picture to the first, (h, w, 2) px, of every second pixel each way.

    Found on pictures of half the size. A coarse search's, or the forward motion turned round where the
    pictures agree better under it: what is hidden in the second picture, or was mistaken for something else,
    goes another way back. NaN where nothing has landed.

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
    turned = _turned(there, _agree(mismatch(before, after, np.nan_to_num(there), box=_BOX)))
    reached = known(turned)
    turned = np.where(reached[:, :, None], turned, searched)
    off = mismatch(after, before, turned, box=_BOX)
    factor = np.where(_agree(off), 1, _CLEARLY)
    right = off <= factor * mismatch(after, before, searched, box=_BOX)
    right |= grown(~reached, 2)  # halved, the outermost that landed hold something else, too
    back = np.where(right[:, :, None], turned, searched)
    back[~reached] = np.nan
    return 2 * back


def quick_way_back(first: np.ndarray, second: np.ndarray, forward: FlowField, options: object) -> np.ndarray:
    """The forward motion turned round, on pictures of half the size, without a search.

    (h, w, 2) px, of every second pixel each way, NaN where nothing has landed. Where several have, the one
    under whose motion the pictures agree: what is hidden lands there too, and is not taken back.
    """
    before, after, there = _halves(first, second, forward)
    return 2 * _turned(there, _agree(mismatch(before, after, np.nan_to_num(there), box=_BOX)))


def _halves(
    first: np.ndarray, second: np.ndarray, forward: FlowField
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    before, after = (halved(to_8bit(grey)) for grey in (first, second))
    return before, after, forward.displacement[::2, ::2] / 2


def _agree(off: np.ndarray) -> np.ndarray:
    return off < _AGREEING * np.median(off[::_EVERY, ::_EVERY]) + _SLACK


def _turned(forward: np.ndarray, fits: np.ndarray) -> np.ndarray:
    """What moved there turned round, at the pixel where it has landed; NaN where nothing has, nor beside.

    Where several have landed, one under whose motion the pictures fit stands.
    """
    height, width = forward.shape[:2]
    x, y = (np.rint(place).astype(np.int32) for place in landing(forward))
    inside = (x >= 0) & (y >= 0) & (x < width) & (y < height)
    turned, place = np.full_like(forward, np.nan), y * width + x
    # Both components are moved as one number: half the time.
    onto, back = turned.reshape(-1, 2).view(np.complex64)[:, 0], (-forward).view(np.complex64)[:, :, 0]
    for some in (inside & ~fits, inside & fits):
        onto[place[some]] = back[some]
    return _closed(turned)


def _closed(motion: np.ndarray) -> np.ndarray:
    """Motion with the mean of what is known beside them where pixels are not known."""
    import cv2

    there = known(motion)
    if there.all():
        return motion
    told = np.where(there[:, :, None], motion, 0)
    total, share = (cv2.boxFilter(v, -1, (3, 3), normalize=False) for v in (told, there.astype(np.float32)))
    beside = ~there & (share > 0.5)
    motion[beside] = total[beside] / share[beside][:, None]
    return motion
