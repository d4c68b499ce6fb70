"""Whether a method got worse than its baseline, by a rule that is fixed before anybody looks.

Two measurements on the same pictures are compared pair by pair, so that what is hard about a picture is the
same for both. For each stratum and quantity, the change is averaged over the pairs of a clip; the clips are
the independent observations. A quantity got worse if

1. the mean change over the clips is above its tolerance, and the whole of its one-sided 95 % interval
   (Student's t over the clips, the level shared among all strata and quantities: Bonferroni) above zero; or
2. on one clip alone it changed by more than a coarse bound, however the others did.

The first finds a small change that is seen everywhere, the second a method that breaks down in one place.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from validation.gate.measurement import GateError, Measurement, PairScore
from validation.scoring.strata import STRATA

SCHEMA_VERSION = 1
LEVEL = 0.95
"""Of the intervals of all strata and quantities together."""
FLOOR = 1e-3
"""px; added to errors before their ratio is taken: below it, a ratio means nothing."""


EVERYWHERE = "everywhere"


@dataclass(frozen=True)
class Quantity:
    """What is compared.

    Attributes
    ----------
    name : str
        A field of `PairScore`.
    relative : bool
        Whether its change is a ratio, told as such less one, or a difference.
    tolerance : float
        Mean change that is never held against a method: other versions of libraries may do as much.
    bound : float
        Change on a single clip that is held against it in any case.
    """

    name: str
    relative: bool
    tolerance: float
    bound: float

    def change(self, before: PairScore, after: PairScore) -> float | None:
        """Worse is positive: logarithm of the ratio, or difference; None where one was not measured."""
        old, new = getattr(before, self.name), getattr(after, self.name)
        if old is None or new is None:
            return None
        return math.log((new + FLOOR) / (old + FLOOR)) if self.relative else new - old

    def told(self, change: float) -> float:
        """The change as a person thinks of it: relative less one, or a difference."""
        return math.expm1(change) if self.relative else change


QUANTITIES = (
    Quantity("median", relative=True, tolerance=0.03, bound=0.25),
    Quantity("p95", relative=True, tolerance=0.05, bound=0.5),
    Quantity("wrong_share", relative=False, tolerance=0.01, bound=0.05),
)


@dataclass(frozen=True)
class Row:
    """One stratum and quantity.

    Attributes
    ----------
    stratum, quantity : str
    before, after : float or None
        Mean over pairs; px or a share. None where nothing was measured.
    change, low : float or None
        Mean change and the lower end of its interval, relative less one or a difference; None without clips.
    clip_count : int
        Clips that have the stratum.
    worst_clip : str
        The clip with the greatest change.
    worst_change : float or None
        Its change.
    reason : str
        Why it counts as worse; empty where it does not.
    """

    stratum: str
    quantity: str
    before: float | None
    after: float | None
    change: float | None
    low: float | None
    clip_count: int
    worst_clip: str
    worst_change: float | None
    reason: str

    @property
    def worse(self) -> bool:
        """Whether it got worse."""
        return bool(self.reason)


def compare(before: Measurement, after: Measurement) -> list[Row]:
    """Compare a measurement with a baseline, stratum by stratum.

    Raises
    ------
    GateError
        They are of different clips.
    """
    if before.clips_digest != after.clips_digest:
        raise GateError("the baseline was measured on other clips: write a new one with --update")
    pairs = [(stratum, quantity) for stratum in STRATA for quantity in QUANTITIES]
    told = [(s, q) for s, q in pairs if any(_scores(before, s))]
    return [_row(stratum, quantity, before, after, len(told)) for stratum, quantity in told]


def document(before: Measurement, rows: list[Row], after: Measurement) -> dict[str, Any]:
    """As `--json` gives it."""
    from dataclasses import asdict

    return {
        "schema_version": SCHEMA_VERSION,
        "method": after.method,
        "baseline_method": before.method,
        "passed": not any(row.worse for row in rows),
        "rows": [{**asdict(row), "worse": row.worse} for row in rows],
        "versions": after.versions,
        "baseline_versions": before.versions,
    }


def _scores(measurement: Measurement, stratum: str) -> Iterator[PairScore]:
    for pairs in measurement.clips.values():
        yield from (pair[stratum] for pair in pairs if stratum in pair)


def _row(stratum: str, quantity: Quantity, before: Measurement, after: Measurement, row_count: int) -> Row:
    changes = _changes_by_clip(stratum, quantity, before, after)
    mean = sum(changes.values()) / len(changes) if changes else None
    low = _lower_end([*changes.values()], row_count)
    worst = max(changes, key=lambda clip: changes[clip], default="")
    return Row(
        stratum,
        quantity.name,
        _mean(getattr(score, quantity.name) for score in _scores(before, stratum)),
        _mean(getattr(score, quantity.name) for score in _scores(after, stratum)),
        None if mean is None else quantity.told(mean),
        None if low is None else quantity.told(low),
        len(changes),
        worst,
        quantity.told(changes[worst]) if changes else None,
        _reason(quantity, mean, low, worst, changes),
    )


def _changes_by_clip(
    stratum: str, quantity: Quantity, before: Measurement, after: Measurement
) -> dict[str, float]:
    found = {}
    for clip, pairs in before.clips.items():
        changes = [
            change
            for old, new in zip(pairs, after.clips[clip], strict=True)
            if stratum in old and (change := quantity.change(old[stratum], new[stratum])) is not None
        ]
        if changes:
            found[clip] = sum(changes) / len(changes)
    return found


def _lower_end(changes: list[float], row_count: int) -> float | None:
    """Lower end of the one-sided interval of the mean; None for fewer than two clips."""
    from scipy.stats import t

    count = len(changes)
    if count < 2:
        return None
    mean = sum(changes) / count
    deviation = math.sqrt(sum((change - mean) ** 2 for change in changes) / (count - 1))
    return float(mean - t.ppf(1 - (1 - LEVEL) / row_count, count - 1) * deviation / math.sqrt(count))


def _reason(
    quantity: Quantity, mean: float | None, low: float | None, worst: str, changes: dict[str, float]
) -> str:
    if mean is not None and low is not None and low > 0 and quantity.told(mean) > quantity.tolerance:
        return EVERYWHERE
    if changes and quantity.told(changes[worst]) > quantity.bound:
        return f"on {worst}"
    return ""


def _mean(values: Iterator[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if known else None
