"""How wrong, and how fast, one method is on one case."""

from statistics import median

import numpy as np

from validation.bench.flow_case import Case
from validation.bench.flow_contender import Contender
from validation.bench.rows import BenchRow
from validation.metrics import end_point_error
from validation.nodes import difference_at, has_node

WRONG_ABOVE = 0.3
"""px."""
INTERVALS = ((68, 1.0), (95, 1.96))
"""Percent of a normal distribution, and the standard deviations they lie within."""


def measured(case: Case, contender: Contender, repeats: int, threads: int | None) -> list[BenchRow]:
    """Rows of one method on one case; times are the median of `repeats` after a first run."""
    seconds = []
    for _ in range(repeats + 1):  # the first waits for kernels
        flow, took = contender.measure(case, threads)
        seconds.append(took)

    def row(metric: str, value: float | None, unit: str, count: int = 1) -> BenchRow:
        version = contender.version
        return BenchRow(case.name, contender.name, version, contender.own, metric, value, unit, count)

    rows = [row("time", median(seconds[1:]), "s/pair", repeats)]
    difference = difference_at(flow.displacement, case.truth, flow.nodes)
    for name, region in case.regions.items():
        told: dict[str, tuple[float | None, str]] = {
            "measured": (100 * float(flow.valid[region].mean()), "%")
        }
        # A grid is judged at its nodes.
        judged = region if flow.nodes is None else region & has_node(flow.nodes)
        told |= _errors(difference[judged])
        if flow.uncertainty is not None:
            told |= _covered(difference[judged], flow.uncertainty[judged])
        rows += [row(f"{name}: {metric}", value, unit) for metric, (value, unit) in told.items()]
    return rows


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
