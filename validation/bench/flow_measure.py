"""How wrong, and how fast, one method is on one case."""

from statistics import median
from typing import TYPE_CHECKING

import numpy as np

from validation.bench.flow_case import Case
from validation.bench.flow_contender import Answer, Subject
from validation.bench.rows import BenchRow, PeerError
from validation.scoring.metrics import end_point_error
from validation.scoring.nodes import difference_at, has_node
from validation.statistics import NORMAL_95

if TYPE_CHECKING:
    from soft.flow import FlowField

WRONG_ABOVE = 0.3
"""px."""
LONGEST = 10.0
"""Once so many seconds are measured, a method is not asked again."""
INTERVALS = ((68, 1.0), (95, NORMAL_95))
"""Percent of a normal distribution, and the standard deviations they lie within."""


def measured(case: Case, subject: Subject, repeats: int, threads: int | None) -> list[BenchRow]:
    """Rows of one method on one case; a single one that says why, where it cannot be run.

    Times are the median of `repeats` after a first run, which waits for kernels and caches; of fewer, where
    they would take longer than `LONGEST`.
    """
    try:
        answer, seconds = _timed(case, subject, repeats, threads)
    except PeerError as missing:
        return [BenchRow(case.name, subject.name, str(missing), subject.own, "time", None, "s/pair", 0)]

    def row(metric: str, value: float | None, unit: str, count: int = 1) -> BenchRow:
        return BenchRow(case.name, subject.name, answer.version, subject.own, metric, value, unit, count)

    return [
        row("time", median(seconds), "s/pair", len(seconds)),
        *(row(metric, *told) for metric, told in _told(case, answer.flow).items()),
    ]


def _timed(case: Case, subject: Subject, repeats: int, threads: int | None) -> tuple[Answer, list[float]]:
    """Last answer, and the seconds of every run that counts."""
    answer = subject.measure(case, threads)
    # A peer that is slow is so for other reasons than a first run's.
    seconds = [answer.seconds] if answer.seconds > LONGEST and not subject.own else []
    while not seconds or (len(seconds) < repeats and sum(seconds) < LONGEST):
        answer = subject.measure(case, threads)
        seconds.append(answer.seconds)
    return answer, seconds


def _told(case: Case, flow: "FlowField") -> dict[str, tuple[float | None, str]]:
    """Metric to value and unit, for every region; a grid is judged at its nodes."""
    difference = difference_at(flow.displacement, case.truth, flow.nodes)
    told: dict[str, tuple[float | None, str]] = {}
    for name, region in case.regions.items():
        judged = region if flow.nodes is None else region & has_node(flow.nodes)
        here = {"measured": (100 * float(flow.valid[region].mean()), "%")} | _errors(difference[judged])
        if flow.uncertainty is not None:
            here |= _covered(difference[judged], flow.uncertainty[judged])
        told |= {f"{name}: {metric}": value for metric, value in here.items()}
    return told


def _errors(difference: np.ndarray) -> dict[str, tuple[float | None, str]]:
    """Metric to value and unit, of measured less true displacement (N, 2) px, NaN where not measured."""
    error = end_point_error(difference[:, 0], difference[:, 1])
    known = error[np.isfinite(error)]
    right = np.count_nonzero(known <= WRONG_ABOVE)
    return {
        "median error": (float(np.median(known)) if known.size else None, "px"),
        "95 % error": (float(np.percentile(known, 95)) if known.size else None, "px"),
        f"wrong by more than {WRONG_ABOVE} px": (100 * (1 - right / error.size) if error.size else None, "%"),
    }


def _covered(difference: np.ndarray, uncertainty: np.ndarray) -> dict[str, tuple[float | None, str]]:
    """How many of the errors, each component for itself, lie within their intervals."""
    z = np.abs(difference / uncertainty)
    z = z[np.isfinite(z)]
    return {
        f"errors within the {share} % interval": (100 * float(np.mean(z < bound)) if z.size else None, "%")
        for share, bound in INTERVALS
    }
