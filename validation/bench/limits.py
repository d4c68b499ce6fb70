"""What no method can do better: the Cramér-Rao bound, and the floor of affine windows.

Rows beside those of the methods, on the same pictures.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from validation.bench.flow_case import Case, analytic_cases, run_cases
from validation.bench.flow_contender import CONTENDERS
from validation.bench.rows import BenchRow
from validation.scoring.metrics import WRONG_ABOVE, ErrorTally, end_point_error
from validation.versions import package_version

if TYPE_CHECKING:
    from synth.scene import AnalyticScene
    from validation.bench.cramer_rao import Bound
    from validation.bench.oracle import Oracle

BOUNDED = ("sand_rotation", "sand_low_contrast")
"""Scenes whose motion is nearly affine in every window, so that the bound is what counts."""
BROKEN = ("shear_band",)
"""Scenes whose motion is not."""
ORACLES = {"oracle": False, "oracle, weighing by its own residuals": True}
"""Subject to `reweigh` of `Oracle.measure`."""
_UNTOLD = ("all", "quiet")
"""Regions of runs in which windows of any size do."""
_PLACES = 6000
"""At most so many pixels of a region, evenly taken: a share of 1 % among them is sure to 0.13 %."""
_WRONG = WRONG_ABOVE[0]
_BOUND_PLACES = 200


def bench_limits(
    rows: Sequence[BenchRow],
    runs: Sequence[Path] = (),
    *,
    threads: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> list[BenchRow]:
    """Bounds and floors on the analytic scenes and on runs.

    Parameters
    ----------
    rows : sequence of BenchRow
        Of `bench_flow` on the analytic scenes: ratios to the bound are told for their methods.
    runs : sequence of Path
        Run folders with footage and a recording.
    """
    from soft.devices import start_taichi
    from synth import load_scene
    from synth.scene import AnalyticScene

    start_taichi("cpu", threads)
    total, told = len(BOUNDED) + len(BROKEN) + len(runs), []
    for done, name in enumerate(BOUNDED, start=1):
        scene = load_scene(name)
        assert isinstance(scene, AnalyticScene)
        told += bound_rows(scene, rows)
        _tell(progress, done, total)
    for done, source in enumerate(analytic_cases(BROKEN), start=len(BOUNDED) + 1):
        case = source()
        told += oracle_rows(case, oracle_of(case), case.regions)
        _tell(progress, done, total)
    for done, folder in enumerate(runs, start=total - len(runs) + 1):
        told += _run_rows(folder, threads)
        _tell(progress, done, total)
    return told


def _tell(progress: Callable[[int, int], None] | None, done: int, total: int) -> None:
    if progress is not None:
        progress(done, total)


def bound_rows(scene: "AnalyticScene", rows: Iterable[BenchRow]) -> list[BenchRow]:
    """Bounds of a scene, and how far above them the median errors of the methods in `rows` lie there."""
    from synth.analytic.truth import displacement_of, scored
    from validation.bench.cramer_rao import scene_bounds

    name = scene.name
    places = evenly(np.argwhere(scored(scene, displacement_of(scene, 0, 1))), _BOUND_PLACES)
    bounds = scene_bounds(scene, places)
    told = []
    for bound in bounds:
        subject = f"Cramér-Rao bound, {bound.side} px"
        told.append(_own(name, subject, "all: median error", bound.median, "px"))
        told.append(_own(name, subject, "all: 95 % error", bound.p95, "px"))
    return told + [ratio for row in rows if row.case == name for ratio in _ratios(row, bounds)]


def _ratios(row: BenchRow, bounds: "Iterable[Bound]") -> list[BenchRow]:
    """By medians: a few failures are told by other rows, and do not hide what the rest is."""
    if row.metric != "all: median error" or row.value is None:
        return []
    return [
        BenchRow(
            row.case, row.subject, row.version, row.own, f"all: median error / bound, {bound.side} px",
            row.value / bound.median, "1", row.repeats,
        )
        for bound in bounds
    ]  # fmt: skip


def oracle_of(case: Case) -> "Oracle":
    """What is known of a case."""
    from validation.bench.oracle import Oracle

    return Oracle.of(case.first, case.second, case.truth, case.regions["all"])


def oracle_rows(
    case: Case,
    oracle: "Oracle",
    regions: Mapping[str, np.ndarray],
    causes: Mapping[str, np.ndarray] | None = None,
) -> list[BenchRow]:
    """What the oracle finds in some regions of a case, and why it is wrong where it is."""
    told = []
    for region, mask in regions.items():
        places = evenly(np.argwhere(mask & case.regions["all"]), _PLACES)
        windows, true = oracle.windows(places), case.truth[places[:, 0], places[:, 1]]
        for subject, reweigh in ORACLES.items():
            difference = oracle.measure(windows, reweigh=reweigh) - true
            told += _error_rows(case.name, subject, region, difference)
            wrong = places[~(end_point_error(*difference.T) <= _WRONG)]
            told += _cause_rows(case.name, subject, f"{region}: wrong", wrong, causes or {})
    return told


def _run_rows(folder: Path, threads: int | None) -> list[BenchRow]:
    from validation.bench.wrong_pixels import causes_in

    case, causes = run_cases([folder])[0](), causes_in(folder, threads)
    regions = {name: mask for name, mask in case.regions.items() if name not in _UNTOLD}
    oracle, ours = oracle_of(case), CONTENDERS[0]
    displacement = ours.measure(case, threads).flow.displacement
    told = oracle_rows(case, oracle, regions, causes)
    return told + missed_rows(case, ours.name, displacement, oracle, regions, causes)


def missed_rows(
    case: Case,
    subject: str,
    displacement: np.ndarray,
    oracle: "Oracle",
    regions: Mapping[str, np.ndarray],
    causes: Mapping[str, np.ndarray],
) -> list[BenchRow]:
    """Where a displacement (H, W, 2) px is wrong: how often the oracle is right there, and where that is."""
    error = end_point_error(*np.moveaxis(displacement - case.truth, -1, 0))
    told = []
    for region, mask in regions.items():
        wrong = evenly(np.argwhere(mask & ~(error <= _WRONG)), _PLACES)
        if not len(wrong):
            continue
        difference = oracle.measure(oracle.windows(wrong)) - case.truth[wrong[:, 0], wrong[:, 1]]
        right = end_point_error(*difference.T) <= _WRONG
        metric = f"{region}: wrong where the oracle is right"
        told.append(_own(case.name, subject, f"{metric}, of all wrong", 100 * float(right.mean()), "%"))
        told += _cause_rows(case.name, subject, metric, wrong[right], causes)
    return told


def evenly(places: np.ndarray, most: int) -> np.ndarray:
    """At most so many of some places (P, 2), in equal steps: int32."""
    step = -(-len(places) // most) if len(places) else 1
    return np.ascontiguousarray(places[::step].astype(np.int32))


def _error_rows(case: str, subject: str, region: str, difference: np.ndarray) -> list[BenchRow]:
    tally = ErrorTally()
    tally.add(*difference.T)
    summary = ErrorTally.summary([tally])
    wrong = summary.wrong_share[str(_WRONG)]
    return [
        _own(case, subject, f"{region}: median error", summary.median, "px"),
        _own(case, subject, f"{region}: 95 % error", summary.p95, "px"),
        _own(case, subject, f"{region}: wrong by more than {_WRONG} px", 100 * (wrong or 0.0), "%"),
    ]


def _cause_rows(
    case: str, subject: str, metric: str, places: np.ndarray, causes: Mapping[str, np.ndarray]
) -> list[BenchRow]:
    if not len(places):
        return []
    return [
        _own(case, subject, f"{metric}, {cause}", 100 * float(mask[places[:, 0], places[:, 1]].mean()), "%")
        for cause, mask in causes.items()
    ]


def _own(case: str, subject: str, metric: str, value: float | None, unit: str) -> BenchRow:
    return BenchRow(case, subject, package_version("softbed"), True, metric, value, unit, 1)
