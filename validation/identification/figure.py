"""What the law was fitted to and what it predicts, beside what was measured."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from synth.rover.law.identification import Trial
from validation.identification.foretelling import Foretold
from validation.identification.runs import SteadyRun
from validation.identification.wheel_rig import RigComparison
from validation.studies.study import plain_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = ("#4c78a8", "#e45756", "#54a24b", "#b07d2b")
_QUANTITIES = (
    ("drawbar_pull", "drawbar pull / load"),
    ("torque", "torque / (load x radius)"),
    ("sinkage", "sinkage / radius"),
)


def identification_figure(
    steady: Sequence[SteadyRun], given: Sequence[Trial], runs: Sequence[Foretold]
) -> "Figure":
    """Steady rolling above, what was not fitted below; points and thin lines are measured."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 8.4), layout="constrained")
    grid = plain_axes(figure, 3, max(3, len(runs)))
    for axes, (name, label) in zip(grid[0], _QUANTITIES, strict=False):
        _draw_steady(axes, name, steady, given)
        axes.set_ylabel(label)
    grid[0, 0].legend(frameon=False, fontsize=8)
    for column, run in enumerate(runs):
        _draw_run(grid[1, column], run, "force_x", run.load)
        _draw_run(grid[2, column], run, "sinkage", run.radius)
        grid[1, column].set_title(run.label.replace("-", " "), fontsize=9)
        grid[2, column].set_xlabel("time [s]; 0: first frame")
    grid[1, 0].set_ylabel("force along x / load")
    grid[2, 0].set_ylabel("sinkage / radius")
    grid[1, 0].legend(frameon=False, fontsize=8)
    for axes in [*grid[0, 3:], *grid[1, len(runs) :], *grid[2, len(runs) :]]:
        axes.set_visible(False)
    return figure


def rig_figure(rig: RigComparison) -> "Figure":
    """Pull and sinkage of the rig's wheel against slip; the law fitted to the driven half, and unfitted."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 3.9), layout="constrained")
    left, right = plain_axes(figure, 1, 2)[0]
    slip = [one.slip for one in rig.measured]
    for axes, name in ((left, "drawbar_pull"), (right, "sinkage")):
        axes.axvspan(-1.05, -0.05, color="0.95", zorder=0)
        axes.plot(slip, _scaled(rig.measured, name), "ko", label="measured")
        axes.plot(slip, _scaled(rig.predicted, name), color=_COLOURS[0], label="fitted to slip >= 0")
        axes.plot(
            slip, _scaled(rig.unfitted, name), "--", color=_COLOURS[1], label="published scale, not fitted"
        )
        axes.set_xlim(-1.05, 1)
        axes.set_xlabel("slip; below 0: skid, not fitted")
    left.set_ylabel("drawbar pull / load")
    right.set_ylabel("sinkage / radius")
    left.legend(frameon=False, fontsize=8)
    return figure


def _draw_steady(axes: "Axes", name: str, steady: Sequence[SteadyRun], given: Sequence[Trial]) -> None:
    loads = sorted({one.trial.load for one in steady})
    for load, colour in zip(loads, _COLOURS, strict=False):
        own = [k for k, one in enumerate(steady) if one.trial.load == load]
        slip = [steady[k].trial.slip for k in own]
        measured = _scaled([steady[k].trial for k in own], name)
        errors = _scaled([steady[k].standard_error for k in own], name)
        label = f"{load:g} N, grains" if len(loads) > 1 else "grains"
        axes.errorbar(slip, measured, errors, fmt="o", capsize=3, color=colour, label=label)
        axes.plot(
            slip, _scaled([given[k] for k in own], name), color=colour, label=label.replace("grains", "law")
        )
    axes.set_xlabel("slip")


def _draw_run(axes: "Axes", run: Foretold, name: str, unit: float) -> None:
    axes.plot(run.time, run.measured[name] / unit, color="0.45", linewidth=0.9, label="grains")
    axes.plot(run.time, run.predicted[name] / unit, color=_COLOURS[0], linewidth=1.6, label="law, not fitted")
    axes.axvline(0, color="0.7", linewidth=0.8, linestyle=":")


def _scaled(trials: Sequence[Trial], name: str) -> np.ndarray:
    units = {"drawbar_pull": lambda one: one.load, "torque": lambda one: one.load * one.radius}
    unit = units.get(name, lambda one: one.radius)
    return np.array([getattr(one, name) / unit(one) for one in trials])
