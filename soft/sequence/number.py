"""Numbers that pictures come with."""

import math

from soft.sequence.error import SequenceError


def positive(name: str, value: object) -> float:
    """Return a finite number above 0, or refuse it by its name."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not (0 < value < math.inf):
        raise SequenceError(f"{name}: {value!r}: must be a number above 0")
    return float(value)


def whole(name: str, value: object, *, least: int) -> int:
    """Return a whole number that is `least` or more, or refuse it by its name."""
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise SequenceError(f"{name}: {value!r}: must be a whole number, {least} or more")
    return value
