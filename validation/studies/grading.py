"""Whether a graded bed's sinkage and forces are those of a uniform one, or only those of another seed.

A bed packed by another seed gives another sinkage, however alike it is made. Only over several seeds of both
can it be said what coarser grains away from the wheel change.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from synth.scene import SoilBinScene
from validation.studies.study import (
    Case,
    Findings,
    Row,
    Run,
    Study,
    changed,
    column,
    plain_axes,
    steady_means,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

REALISATIONS = 6
"""Seeds of either bed."""
QUICK_REALISATIONS = 3
GRADED, UNIFORM = "graded", "uniform"
_COLOURS = {UNIFORM: "#4c78a8", GRADED: "#e45756"}
_QUANTITIES = {"sinkage": "mm", "drawbar_pull": "N", "torque": "N m"}
_CONFIDENCE = 0.95


class Grading(Study):
    """A graded bed and one of its finest grains throughout, each packed by several seeds."""

    scene = "rolling_wheel"
    columns: ClassVar[Mapping[str, str]] = {
        "bed": "",
        "seed": "1",
        "grain_count": "1",
        "relative_density": "1",
        **_QUANTITIES,
    }

    def cases(self, scene: SoilBinScene, *, quick: bool) -> list[Case]:
        """Every seed with both beds."""
        if scene.bed.coarsening == 1:
            raise ValueError(f"{scene.name}: bed.coarsening = 1: a graded bed is needed")
        uniform = changed(scene, bed={"coarsening": 1.0, "fine": None})
        seeds = range(scene.seed, scene.seed + (QUICK_REALISATIONS if quick else REALISATIONS))
        return [
            Case(f"{bed}-seed-{seed}", changed(one, seed=seed))
            for seed in seeds
            for bed, one in ((GRADED, scene), (UNIFORM, uniform))
        ]

    def find(self, runs: Sequence[Run]) -> Findings:
        """Means over time of every run, and what the two beds differ by."""
        rows = [_row(run) for run in runs]
        return Findings(rows, _conclusion(rows))

    def draw(self, findings: Findings) -> "Figure":
        """Sinkage against density, and every quantity by bed."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(9.6, 3.6), layout="constrained")
        by_density, *by_bed = plain_axes(figure, 1, 1 + len(_QUANTITIES))[0]
        for place, (bed, colour) in enumerate(_COLOURS.items()):
            rows = _of(findings.rows, bed)
            density, sinkage = column(rows, "relative_density"), column(rows, "sinkage")
            by_density.plot(density, sinkage, "o", color=colour, markersize=4, label=bed)
            for axes, name in zip(by_bed, _QUANTITIES, strict=True):
                values = column(rows, name)
                axes.plot(np.full(values.size, place), values, "o", color=colour, alpha=0.4, markersize=4)
                error = values.std(ddof=1) / np.sqrt(values.size)
                axes.errorbar(place, values.mean(), error, fmt="_", color=colour, markersize=18, capsize=6)
        by_density.set_xlabel("relative density of the (fine) bed")
        by_density.set_ylabel("sinkage [mm]")
        by_density.legend(frameon=False, ncols=2, loc="lower center", bbox_to_anchor=(0.5, 1.0))
        for axes, (name, unit) in zip(by_bed, _QUANTITIES.items(), strict=True):
            axes.set_ylabel(f"{name.replace('_', ' ')} [{unit}]")
            axes.set_xticks(range(len(_COLOURS)), list(_COLOURS))
            axes.set_xlim(-0.6, len(_COLOURS) - 0.4)
        figure.supxlabel(
            "a point: a seed's mean over time; bars: mean over seeds and its standard error", fontsize=8
        )
        return figure


STUDY = Grading()


@dataclass(frozen=True)
class Difference:
    """What graded beds have more of than uniform ones: best estimate and bounds of its 95 % interval."""

    value: float
    low: float
    high: float

    @classmethod
    def estimated(cls, value: float, error: float, freedom: float) -> "Difference":
        """From a standard error and its degrees of freedom, by Student's distribution."""
        from scipy.stats import t

        reach = float(t.ppf((1 + _CONFIDENCE) / 2, freedom)) * error
        return cls(value, value - reach, value + reach)

    def told(self, unit: str, base: float) -> str:
        """In words, and as shares of a base."""
        share, low, high = (100 * value / abs(base) for value in (self.value, self.low, self.high))
        return f"{self.value:+.2g} {unit} ({share:+.0f} %, 95 %: {low:+.0f} to {high:+.0f} %)"


def difference(rows: Sequence[Row], name: str) -> Difference:
    """Mean of the graded beds less that of the uniform ones; Welch's interval."""
    graded, uniform = (column(_of(rows, bed), name) for bed in (GRADED, UNIFORM))
    squares = [values.var(ddof=1) / values.size for values in (graded, uniform)]
    freedom = sum(squares) ** 2 / sum(
        s**2 / (v.size - 1) for s, v in zip(squares, (graded, uniform), strict=True)
    )
    return Difference.estimated(float(graded.mean() - uniform.mean()), float(np.sqrt(sum(squares))), freedom)


def difference_at_one_density(rows: Sequence[Row], name: str) -> Difference:
    """The same between beds of one density: least squares of a line in density, with a step between beds."""
    values, density = column(rows, name), column(rows, "relative_density")
    step = np.array([row["bed"] == GRADED for row in rows], float)
    terms = np.stack([np.ones(values.size), step, density - density.mean()], axis=1)
    fitted, *_ = np.linalg.lstsq(terms, values, rcond=None)
    freedom = values.size - terms.shape[1]
    variance = np.sum((values - terms @ fitted) ** 2) / freedom
    error = np.sqrt(variance * np.linalg.inv(terms.T @ terms)[1, 1])
    return Difference.estimated(float(fitted[1]), float(error), freedom)


def _row(run: Run) -> Row:
    recording, bed = run.recording(), run.case.scene.bed
    means = steady_means(recording)
    return {
        "bed": UNIFORM if bed.coarsening == 1 else GRADED,
        "seed": float(run.case.scene.seed),
        "grain_count": float(recording.data.sizes["particle"]),
        "relative_density": float(recording.data.attrs.get("relative_density", np.nan)),
        "sinkage": 1000 * means["sinkage"][0],
        "drawbar_pull": means["force_x"][0],
        "torque": means["torque"][0],
    }


def _of(rows: Sequence[Row], bed: str) -> list[Row]:
    return [row for row in rows if row["bed"] == bed]


def _conclusion(rows: Sequence[Row]) -> str:
    uniform = _of(rows, UNIFORM)
    told = [
        f"{name.replace('_', ' ')} {difference(rows, name).told(unit, float(column(uniform, name).mean()))}"
        for name, unit in _QUANTITIES.items()
    ]
    dense, loose = (column(_of(rows, bed), "relative_density").mean() for bed in (GRADED, UNIFORM))
    alike = difference_at_one_density(rows, "sinkage")
    return (
        f"Graded less uniform over {len(uniform)} seeds: {', '.join(told)}; "
        f"relative density {dense:.2f} against {loose:.2f}; "
        f"sinkage at equal density {alike.told('mm', float(column(uniform, 'sinkage').mean()))}."
    )
