"""What the estimators taken from OpenCV share."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from soft.flow.field import FlowError


@contextmanager
def opencv_threads(count: int | None) -> Iterator[None]:
    """Run OpenCV on `count` threads inside the block and restore its setting after; None leaves it alone."""
    if count is None:
        yield
        return
    if isinstance(count, bool) or not isinstance(count, int) or count < 1:
        raise FlowError(f"threads: {count!r}: must be a whole number of at least 1")
    import cv2

    before = cv2.getNumThreads()
    cv2.setNumThreads(count)
    try:
        yield
    finally:
        cv2.setNumThreads(before)


def to_8bit(picture: np.ndarray) -> np.ndarray:
    """Grey 0-255 rounded to uint8, contiguous.

    Exact for 8-bit pictures. Deeper ones lose up to half a grey level a pixel, which matters only where the
    texture has a contrast of a few grey levels.
    """
    return np.ascontiguousarray(np.clip(np.rint(picture), 0, 255).astype(np.uint8))


def halved(picture: np.ndarray) -> np.ndarray:
    """A picture of half the size, rounded up, by averaging."""
    import cv2

    height, width = picture.shape
    return cv2.resize(picture, ((width + 1) // 2, (height + 1) // 2), interpolation=cv2.INTER_AREA)
