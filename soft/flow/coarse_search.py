"""Motion to start from, found coarsely: a search on a pyramid, the shift that most of a picture shares."""

import numpy as np

LARGE = 8.0
"""A common shift beyond this is worth a start of its own, px."""
_PATCH = 8
_LARGE_PICTURE = 256
"""Px each way."""
_CLEAR = 0.25
"""Height of the phase correlation's peak from which on most of the picture shares a shift."""


def least_side(finest: int) -> int:
    """Px that pictures must have each way for `search`."""
    return int(_PATCH * 2 ** (finest + 1))


_QUICK = {"PatchStride": 4, "GradientDescentIterations": 12, "VariationalRefinementIterations": 0}
"""Settings of a search that takes a third of the time; most fits that start from it end where others do."""


def search(first: np.ndarray, second: np.ndarray, *, finest: int, quick: bool = False) -> np.ndarray:
    """Motion (H, W, 2) px by dense inverse search (Kroeger, Timofte, Dai, Van Gool, ECCV 2016).

    Parameters
    ----------
    first, second : (H, W) uint8
    finest : int
        Level of the pyramid on which it ends: 1 = half resolution.
    quick : bool, optional
        In a third of the time.
    """
    import cv2

    solver = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    solver.setFinestScale(finest)
    if quick:
        for name, value in _QUICK.items():
            getattr(solver, f"set{name}")(value)
    return solver.calc(first, second, None)  # type: ignore[call-overload, no-any-return]


def common_shift(first: np.ndarray, second: np.ndarray, *, large: float = LARGE) -> np.ndarray | None:
    """Shift from the first to the second picture, whole px (x, y) float32; None unless clear and `large`.

    By phase correlation of pictures faded out towards their border (Hann window): borders that do not match
    their opposites would hide the shift. Large pictures are taken at half their size.
    """
    import cv2

    scale = 2 if min(first.shape) >= _LARGE_PICTURE else 1
    before, after = (_reduced(grey.astype(np.float32), scale) for grey in (first, second))
    window = cv2.createHanningWindow((before.shape[1], before.shape[0]), cv2.CV_32F)
    found, peak = cv2.phaseCorrelate(before, after, window)
    shift = np.rint(scale * np.array(found)).astype(np.float32)
    return shift if peak > _CLEAR and np.hypot(*shift) > large else None


def _reduced(grey: np.ndarray, scale: int) -> np.ndarray:
    import cv2

    return cv2.resize(grey, None, fx=1 / scale, fy=1 / scale, interpolation=cv2.INTER_AREA)


def mismatch(first: np.ndarray, second: np.ndarray, motion: np.ndarray, *, box: int = 15) -> np.ndarray:
    """Mean difference of grey levels in a box around each pixel, if it moves so: (H, W) float32."""
    import cv2

    height, width = first.shape
    x = np.arange(width, dtype=np.float32) + motion[:, :, 0]
    y = np.arange(height, dtype=np.float32)[:, None] + motion[:, :, 1]
    there = cv2.remap(second, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return cv2.boxFilter(cv2.absdiff(first, there), cv2.CV_32F, (box, box))


def better_of(
    first: np.ndarray, second: np.ndarray, one: np.ndarray, other: np.ndarray, *, box: int = 15
) -> np.ndarray:
    """The one of two motions (H, W, 2) under which the pictures agree better, in a box around each pixel."""
    off, other_off = (mismatch(first, second, motion, box=box) for motion in (one, other))
    better = off < other_off
    return np.where(better[:, :, None], one, other)
