"""Pixel size from two points a known length apart."""

import math
from collections.abc import Sequence

from soft.calibration.error import CalibrationError


def metres_per_pixel_between(first: Sequence[float], second: Sequence[float], *, length: float) -> float:
    """Pixel size on the glass in m, from a scale that lies against it.

    Parameters
    ----------
    first, second : (x, y)
        Ends of a known length in px.
    length : float
        In m.

    Raises
    ------
    CalibrationError
        If the points are one, or the length is not above 0.
    """
    ends = [tuple(float(part) for part in end) for end in (first, second)]
    pixels = math.dist(*ends)
    if not (0 < length < math.inf):
        raise CalibrationError(f"scale length: {length!r}: must be above 0 m")
    if not (0 < pixels < math.inf):
        raise CalibrationError(f"scale points: {ends[0]} and {ends[1]}: must be two points")
    return length / pixels
