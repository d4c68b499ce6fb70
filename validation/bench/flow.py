"""Flow methods side by side on the same pictures: how wrong, and how fast.

The analytic scenes at their own seeds, and any runs that are given. No constant of ours was tuned on them:
that was done on analytic scenes, `rolling_wheel` and `bucket` at seed 101.
"""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from validation.bench.rows import BenchRow
from validation.metrics import end_point_error
from validation.versions import package_version

ANALYTIC = (
    "sand_rotation",
    "sand_low_contrast",
    "sand_defocus",
    "sand_aliased",
    "shear_band",
    "sinusoidal_strain",
)
_BAND_RADIUS = 220.0
"""Of `shear_band`, px."""
_BAND_WITHIN = 12.0
"""Half the width of the ring around it that is told apart, px."""
WRONG_ABOVE = 0.3
"""px."""


@dataclass(frozen=True)
class Contender:
    """A method with options."""

    name: str
    method: str
    own: bool
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def version(self) -> str:
        """Of the package it comes from."""
        return package_version("softbed" if self.own else "opencv-python-headless")


CONTENDERS = (
    Contender("robust-affine", "robust-affine", True),
    Contender("robust-affine, fast", "robust-affine", True, {"preset": "fast"}),
    Contender("DIS, medium", "dis", False),
    Contender("DIS, medium, to full resolution", "dis", False, {"finest_scale": 0}),
    Contender("Farnebäck", "farneback", False),
)


@dataclass(frozen=True, eq=False)
class Case:
    """Grey pictures 0-255, their true displacement (H, W, 2) px, and the pixels that errors are told for."""

    name: str
    first: np.ndarray
    second: np.ndarray
    truth: np.ndarray
    regions: Mapping[str, np.ndarray]
    soil: np.ndarray | None = None


def bench_flow(
    *,
    runs: Sequence[Path] = (),
    contenders: Sequence[Contender] = CONTENDERS,
    scenes: Sequence[str] = ANALYTIC,
    repeats: int = 5,
    threads: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> list[BenchRow]:
    """Errors and seconds a pair of every method on every case, in turn.

    Parameters
    ----------
    runs : sequence of Path
        Run folders with footage; of each the middle picture pair is taken.
    repeats : int
        Of the timing; rows give the median. Results do not change.
    threads : int, optional
        Default: every core.
    """
    rows: list[BenchRow] = []
    total = len(scenes) + len(runs)
    for done, case in enumerate(_cases(scenes, runs), start=1):
        for contender in contenders:
            rows += _measured(case, contender, repeats, threads)
        if progress is not None:
            progress(done, total)
    return rows


def _cases(scenes: Sequence[str], runs: Sequence[Path]) -> Iterator[Case]:
    for name in scenes:
        yield _analytic(name)
    for folder in runs:
        yield _of_run(folder)


def _analytic(name: str) -> Case:
    from soft.sequence import to_grey
    from synth import picture_pair

    pair = picture_pair(name)
    regions = {"all": pair.valid}
    if name == "shear_band":
        height, width = pair.valid.shape
        y, x = np.mgrid[:height, :width]
        radius = np.hypot(x - (width - 1) / 2, y - (height - 1) / 2)
        regions["band"] = np.abs(radius - _BAND_RADIUS) < _BAND_WITHIN
        regions["inside the band"] = radius < _BAND_RADIUS - 2 * _BAND_WITHIN
    first, second = (to_grey(picture, name=name) for picture in (pair.first, pair.second))
    return Case(name, first, second, pair.displacement, regions)


def _of_run(folder: Path) -> Case:
    from soft.segmentation import soil_mask
    from soft.sequence import to_grey
    from synth.footage import Footage
    from validation.strata import find_strata

    with Footage.open(folder / "footage") as footage:
        pair = footage.pair_count // 2
        first, second = (to_grey(footage.picture(k), name=footage.frames[k].name) for k in (pair, pair + 1))
        truth = footage.truth(pair)
        displacement = np.stack([truth["u"].values, truth["v"].values], axis=-1)
        masks = find_strata(truth).masks
    regions = {name: masks[name] for name in ("all", "moving", "complex", "quiet") if masks[name].any()}
    return Case(folder.resolve().name, first, second, displacement, regions, soil_mask(first).mask)


def _measured(case: Case, contender: Contender, repeats: int, threads: int | None) -> list[BenchRow]:
    from soft.analysis import around
    from soft.flow import estimate_flow, find_estimator

    keeps = case.soil is not None and find_estimator(contender.method).keeps_to_mask
    mask = around(case.soil) if keeps else None  # type: ignore[arg-type]
    seconds = []
    for _ in range(repeats + 1):  # the first waits for kernels
        began = time.perf_counter()
        flow = estimate_flow(
            case.first, case.second, method=contender.method, mask=mask, threads=threads, **contender.options
        )
        seconds.append(time.perf_counter() - began)

    def row(metric: str, value: float, unit: str, count: int = 1) -> BenchRow:
        version = contender.version
        return BenchRow(case.name, contender.name, version, contender.own, metric, value, unit, count)

    rows = [row("time", median(seconds[1:]), "s/pair", repeats)]
    for name, region in case.regions.items():
        difference = flow.displacement[region] - case.truth[region]
        error = end_point_error(difference[:, 0], difference[:, 1])
        known = error[np.isfinite(error)]
        rows.append(row(f"{name}: median error", float(np.median(known)), "px"))
        rows.append(row(f"{name}: 95 % error", float(np.percentile(known, 95)), "px"))
        wrong = 1 - np.count_nonzero(known <= WRONG_ABOVE) / error.size
        rows.append(row(f"{name}: wrong by more than {WRONG_ABOVE} px", 100 * wrong, "%"))
        if flow.uncertainty is not None:
            z = np.abs(difference / flow.uncertainty[region])
            z = z[np.isfinite(z)]
            for share, bound in ((68, 1.0), (95, 1.96)):
                covered = 100 * float(np.mean(z < bound))
                rows.append(row(f"{name}: errors within the {share} % interval", covered, "%"))
    return rows
