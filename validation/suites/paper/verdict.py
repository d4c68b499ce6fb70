"""Published numbers beside ours, and the verdict by a rule that is fixed before running.

Reproduced: the interval that the source allows for and ours overlap. Else it differs; by how much is told,
and why, as far as we know. Judged is `soft-2014`, what the authors ran as far as their text tells, on
pictures of the severity `paper`; what others give, or clean pictures, stands beside.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from validation.published import Published
from validation.statistics import Interval

REPRODUCED, DIFFERS, NOT_MEASURED = "reproduced", "differs", "not measured"


@dataclass(frozen=True)
class Variant:
    """How something was measured.

    Attributes
    ----------
    method : str
        As `soft.analyze` takes it.
    severity : str
        Of the pictures.
    """

    method: str
    severity: str


JUDGED = Variant("soft-2014", "paper")


@dataclass(frozen=True)
class Told:
    """One of our numbers.

    Attributes
    ----------
    quantity : str
        As the table of published numbers calls it.
    interval : Interval
    case : str
        What tells it from others of the same quantity: a soil.
    truth : float
        What the true motion of the same pictures gives in the same way; NaN where that was not asked for. It
        tells the measurement's doing from the soil's.
    """

    quantity: str
    interval: Interval
    case: str = ""
    truth: float = np.nan


@dataclass(frozen=True)
class Row:
    """A published number, ours, and what follows.

    Attributes
    ----------
    experiment : str
        Its name.
    published : Published
    case : str
    truth : float
        As of `Told`.
    variant : Variant
    ours : Interval or None
        None: not measured.
    verdict, reason : str
    """

    experiment: str
    published: Published
    case: str
    variant: Variant
    ours: Interval | None
    truth: float
    verdict: str
    reason: str


def judge(published: Published, ours: Interval | None) -> str:
    """Whether both intervals overlap; a number without an interval is a point."""
    if ours is None or np.isnan(ours.value):
        return NOT_MEASURED
    low, high = bounds(ours)
    return REPRODUCED if low <= published.high and published.low <= high else DIFFERS


def bounds(ours: Interval) -> tuple[float, float]:
    """The ends of an interval; the value itself where it has none."""
    return (ours.value, ours.value) if np.isnan(ours.low) else (ours.low, ours.high)


def reason(
    published: Published,
    ours: Interval | None,
    causes: Mapping[tuple[str, str], str],
    truth: float = np.nan,
) -> str:
    """By how much a number differs, and why.

    Parameters
    ----------
    truth : float, optional
        As of `Told`: where it differs, too, it is the soil that does, else the measurement.
    causes : mapping
        What is known of why, by quantity and side (`above` or `below` what is published).
    """
    if judge(published, ours) != DIFFERS or ours is None:
        return ""
    low, high = bounds(ours)
    side = "above" if low > published.high else "below"
    gap = low - published.high if side == "above" else published.low - high
    unit = "" if published.unit == "1" else f" {published.unit}"
    told = [f"{side} by {gap:.2g}{unit}"]
    if not np.isnan(truth):
        differs = not published.low <= truth <= published.high
        told.append(
            "so does the truth of these pictures" if differs else "the truth of these pictures does not"
        )
    told.append(causes.get((published.quantity, side), ""))
    return "; ".join(part for part in told if part)


def difference(first: Interval, second: Interval) -> Interval:
    """First less second, of simulations that know nothing of each other: half-widths add as squares do."""
    value = first.value - second.value
    half = math.hypot(*((one.high - one.low) / 2 for one in (first, second)))
    count = min(first.realisation_count, second.realisation_count)
    return Interval(value, value - half, value + half, count, first.pair_count + second.pair_count)


def ratio(first: Interval, second: Interval) -> Interval:
    """First over second, both above zero, likewise: relative half-widths add as squares do."""
    value = first.value / second.value
    spread = math.hypot(*((one.high - one.low) / 2 / one.value for one in (first, second)))
    count = min(first.realisation_count, second.realisation_count)
    return Interval(
        value, value / (1 + spread), value * (1 + spread), count, first.pair_count + second.pair_count
    )


def published_words(published: Published) -> str:
    """The published number as a table shows it."""
    low, value, high = published.low, published.value, published.high
    if np.isinf(high):
        return f"at least {low:g}"
    if np.isnan(value):
        return f"{low:g} to {high:g}"
    return f"{value:g}" if low == high else f"{value:g} ({low:g} to {high:g})"


def our_words(ours: Interval | None) -> str:
    """Our number as a table shows it."""
    if ours is None or np.isnan(ours.value):
        return "-"
    value = number(ours.value)
    if np.isnan(ours.low):
        return value
    return f"{value} ({number(ours.low)} to {number(ours.high)})"


def number(value: float) -> str:
    """One of our numbers as a table shows it."""
    return f"{value:.3f}" if abs(value) < 1 else f"{value:.3g}"
