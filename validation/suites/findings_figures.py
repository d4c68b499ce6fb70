"""Figures of the README and of docs/complex_regions.md, from kept tables."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from soft.figures.page import plain_axes, save_figure
from validation.scoring.error_profile import CAUSES, EXPLANATIONS
from validation.scoring.metrics import WRONG_ABOVE
from validation.statistics import Interval
from validation.suites.complex_flow import BIN_SCENES, SOFT
from validation.suites.explained import Explained
from validation.suites.figures import draw_cost, draw_heat_map, range_label
from validation.suites.findings import INSTEAD
from validation.suites.headline import GROUP, grouped
from validation.suites.kept import Kept
from validation.suites.leaderboard import STRATA, WRONG, standings, usual
from validation.suites.severities import CLEAN, PAPER

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = {SOFT: "#e45756", INSTEAD: "#4c78a8"}
_SHOWN = ("distance_to_implement", "distance_to_discontinuity", "discontinuity_jump", "strain_rate")
_DOTS_PER_INCH = 110


def write_figures(kept: Kept, folder: Path) -> list[Path]:
    """Write every figure as PNG, and return where they are."""
    folder.mkdir(parents=True, exist_ok=True)
    return [
        save_figure(draw(kept), folder / name, dots_per_inch=_DOTS_PER_INCH) for name, draw in FIGURES.items()
    ]


def _cost(kept: Kept) -> "Figure":
    board = standings(usual(kept.lines, PAPER), [])
    points = {
        one.method: (one.seconds, 100 * share.value, 100 * share.low, 100 * share.high)
        for one in board
        if (share := one.decisive)
    }
    return draw_cost(points, label="wrong by more than 0.3 px in complex flow [%]")


def _heat_map(kept: Kept) -> "Figure":
    lines = usual(kept.lines, PAPER)
    methods = [one.method for one in standings(lines, [])]
    scenes = list(dict.fromkeys(line["scene"] for line in lines))
    shares = {stratum: np.full((len(scenes), len(methods)), np.nan) for stratum in STRATA}
    for (scene, stratum, method), own in grouped(lines, (GROUP[0], "stratum", "method")).items():
        values = np.array([line[WRONG] for line in own])
        if stratum in shares and np.isfinite(values).any():
            shares[stratum][scenes.index(scene), methods.index(method)] = np.nanmean(values)
    return draw_heat_map(shares, scenes, methods)


def _where(kept: Kept) -> "Figure":
    """Share of wrong pixels and median error against distances, jump and shear."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12.5, 6.2), layout="constrained")
    grid = figure.subplots(2, len(_SHOWN), sharex="col")
    rows: tuple[tuple[str, Callable[..., Interval | None], float], ...] = (
        (f"wrong by more than {WRONG_ABOVE[0]} px [%]", Explained.share_wrong, 100.0),
        ("median error [px]", Explained.median, 1.0),
    )
    for row, (label, quantity, factor) in zip(grid, rows, strict=True):
        for axes, name in zip(row, _SHOWN, strict=True):
            _draw_profile(axes, kept, name, quantity, factor)
        row[0].set_ylabel(label)
    for axes, name in zip(grid[-1], _SHOWN, strict=True):
        explanation = EXPLANATIONS[name]
        count = len(explanation.edges) - 1
        axes.set_xticks(
            range(count), [range_label(explanation.edges, k) for k in range(count)], rotation=45, ha="right"
        )
        axes.set_xlabel(f"{explanation.meaning} [{explanation.unit}]", fontsize=9)
    grid[0][0].legend(frameon=False, fontsize=9)
    return figure


def _draw_profile(
    axes: "Axes", kept: Kept, name: str, quantity: Callable[..., Interval | None], factor: float
) -> None:
    plain_axes(axes)
    axes.tick_params(labelsize=8)
    count = len(EXPLANATIONS[name].edges) - 1
    for method, colour in _COLOURS.items():
        for severity, style in ((PAPER, "-"), (CLEAN, "--")):
            told = Explained.of(kept.profiles, method, severity, BIN_SCENES)
            found = {k: one for k in range(count) if (one := quantity(told, name, k)) is not None}
            values = np.array([[one.value, one.low, one.high] for one in found.values()]) * factor
            if not len(values):
                continue
            places = list(found)
            axes.plot(places, values[:, 0], style, color=colour, label=f"{method}, {severity}", linewidth=1.5)
            if severity == PAPER:
                axes.fill_between(
                    places, np.maximum(values[:, 1], 0), values[:, 2], color=colour, alpha=0.18, linewidth=0
                )
    axes.set_ylim(0, _top(axes))


def _top(axes: "Axes") -> float:
    """Room for the means; an interval of few pixels may reach beyond."""
    return 1.35 * max((float(np.nanmax(line.get_ydata())) for line in axes.get_lines()), default=1.0)


def _causes(kept: Kept) -> "Figure":
    """What share of each cause is wrong, and which share of all wrong pixels it makes."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.5, 4.0), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    places = np.arange(len(CAUSES))
    for number, (method, colour) in enumerate(_COLOURS.items()):
        told = Explained.of(kept.profiles, method, PAPER, BIN_SCENES)
        shift = 0.4 * number - 0.2
        among = range(len(CAUSES))
        _bars(left, places + shift, [told.share_wrong("cause", k) for k in among], colour, method)
        shares = [told.share_of("cause", k, among, "wrong_count") for k in among]
        _bars(right, places + shift, shares, colour, method)
    left.set_yticks(places, CAUSES)
    left.invert_yaxis()
    left.set_xlabel(f"of these pixels, wrong by more than {WRONG_ABOVE[0]} px [%]")
    right.set_xlabel("of all wrong pixels, these [%]")
    left.legend(frameon=False, fontsize=9)
    return figure


def _bars(axes: "Axes", places: np.ndarray, found: list[Interval | None], colour: str, label: str) -> None:
    plain_axes(axes)
    known = [(place, one) for place, one in zip(places, found, strict=True) if one is not None]
    values = np.array([100 * one.value for _, one in known])
    ends: Any = np.array([[100 * (one.value - one.low), 100 * (one.high - one.value)] for _, one in known]).T
    axes.barh([place for place, _ in known], values, 0.38, color=colour, label=label)
    if len(known):
        low = np.minimum(np.nan_to_num(ends[0]), values)
        axes.errorbar(
            values,
            [place for place, _ in known],
            xerr=[low, np.nan_to_num(ends[1])],
            fmt="none",
            ecolor="0.25",
            elinewidth=1,
        )
    axes.set_xlim(0, 100)


FIGURES: dict[str, Callable[[Kept], "Figure"]] = {
    "leaderboard-time.png": _cost,
    "leaderboard-scenes.png": _heat_map,
    "complex-where.png": _where,
    "complex-causes.png": _causes,
}
