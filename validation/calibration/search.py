"""Bracketed search on a rising function that carries the noise of a few seeds."""

from collections.abc import Callable


class OutOfReachError(ValueError):
    """No argument gives what is wanted; the message says what can be had."""


def search(
    value_at: Callable[[float], float],
    target: float,
    *,
    low: float,
    high: float,
    resolution: float,
    tolerance: float,
) -> float:
    """Argument, a multiple of `resolution`, whose value lies nearest to the target of all that were tried.

    Regula falsi; after a step that left more than half of the bracket, the next one halves it. It ends at a
    value within `tolerance`, or where no argument is left inside the bracket.

    Parameters
    ----------
    value_at : callable
        Rises with its argument but for noise; equal arguments give equal values.
    low, high : float
        Multiples of `resolution`.

    Raises
    ------
    OutOfReachError
        The target does not lie between the values at `low` and `high`.
    """
    ends = [(low, value_at(low) - target), (high, value_at(high) - target)]
    tried = list(ends)
    if ends[0][1] > tolerance or ends[1][1] < -tolerance:
        raise OutOfReachError(
            f"{target:.3g}: within reach is {ends[0][1] + target:.3g} to {ends[1][1] + target:.3g}"
        )
    halve = False
    while min(abs(miss) for _, miss in tried) > tolerance:
        (left, low_miss), (right, high_miss) = ends
        if right - left < 1.5 * resolution:
            break
        share = 0.5 if halve else low_miss / (low_miss - high_miss)
        inside = round((left + share * (right - left)) / resolution) * resolution
        place = min(max(inside, left + resolution), right - resolution)
        miss = value_at(place) - target
        tried.append((place, miss))
        ends[0 if miss < 0 else 1] = (place, miss)
        halve = not halve and ends[1][0] - ends[0][0] > 0.5 * (right - left)
    return min(tried, key=lambda one: abs(one[1]))[0]
