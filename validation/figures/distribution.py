"""How errors are distributed (Figs. 8, 9)."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from validation.figures.maps import STRATUM_COLOURS
from validation.pair_view import Measured

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BOUNDS = {50: ("median", "-"), 95: ("95 %", "--")}
_SHOWN = 99.0
_LEAST_RANGE = 0.1
_SHADE = {50: "#4c78a8", 95: "#b5cbe3", 100: "#e3e3e3"}


def draw_histogram(
    measured: Measured, strata: Mapping[str, np.ndarray], *, published: Mapping[str, float] | None = None
) -> "Figure":
    """Distribution of the error in each stratum, with the median and 95 % of all.

    Parameters
    ----------
    measured : Measured
        One method on one pair.
    strata : mapping
        (H, W) bool masks.
    published : mapping, optional
        Published errors in px by name, drawn beside.
    """
    from matplotlib.figure import Figure

    from soft.figures.page import plain_axes

    figure = Figure(figsize=(6.4, 4.0), layout="constrained")
    axes = plain_axes(figure.subplots())
    axes.set_xscale("log")
    edges = np.geomspace(0.003, 30, 81)
    for name, colour in STRATUM_COLOURS.items():
        error = _known(measured.error[strata[name]]).clip(edges[0], edges[-1])
        if error.size:
            share, _ = np.histogram(error, edges)
            axes.stairs(100 * share / error.size, edges, color=colour, label=name, linewidth=1.8)
    _mark_bounds(axes, _known(measured.error), published or {})
    axes.set_xlim(edges[0], edges[-1])
    axes.set_xlabel("end-point error [px]")
    axes.set_ylabel("pixels of the stratum [%]")
    axes.legend(frameon=False, fontsize=9)
    return figure


def distribution_figure(
    measured: Measured,
    strata: Mapping[str, np.ndarray],
    *,
    name: str = "",
    published: Mapping[str, float] | None = None,
) -> "Figure":
    """Distribution of the error by magnitude with its confidence bounds (Figs. 8, 9).

    Left, how often each magnitude is, shaded up to the bounds that hold half and 95 % of all pixels; right,
    the share of pixels of each stratum within a magnitude. A pixel that was not measured is in none of them.

    Parameters
    ----------
    measured : Measured
        One method on one pair.
    strata : mapping
        (H, W) bool masks.
    name : str, optional
        What the method is called.
    published : mapping, optional
        Published bounds in px by name, drawn beside.
    """
    from matplotlib.figure import Figure

    from soft.figures.page import plain_axes

    error = _known(measured.error)
    figure = Figure(figsize=(7.0, 3.2), layout="constrained")
    left, right = (plain_axes(axes) for axes in figure.subplots(1, 2))
    top = max(float(np.percentile(error, _SHOWN)), _LEAST_RANGE) if error.size else _LEAST_RANGE
    _shaded(left, error, top)
    _mark_bounds(left, error, published or {})
    for stratum, colour in STRATUM_COLOURS.items():
        _cumulate(right, _known(measured.error[strata[stratum]]), stratum, colour)
    _cumulate(right, error, "all", "black", style="--")
    for axes in (left, right):
        axes.set_xlim(0, top)
        axes.set_ylim(bottom=0)
        axes.set_xlabel("end-point error [px]", fontsize=9)
    left.set_ylabel("pixels [%]", fontsize=9)
    right.set_ylabel("pixels within [%]", fontsize=9)
    right.set_ylim(0, 102)
    left.set_title(f"Motion error, {error.size} pixels{name and f' ({name})'}", fontsize=10, loc="left")
    left.legend(framealpha=1, edgecolor="none", fontsize=8)
    right.legend(frameon=False, fontsize=8, loc="lower right")
    return figure


def _known(error: np.ndarray) -> np.ndarray:
    return error[np.isfinite(error)]


def _shaded(axes: "Axes", error: np.ndarray, top: float) -> None:
    """Bars of the histogram, darker within the bounds."""
    if not error.size:
        return
    edges = np.linspace(0, top, 61)
    share = 100 * np.histogram(error, edges)[0] / error.size
    middle = (edges[:-1] + edges[1:]) / 2
    colours = np.full(middle.size, _SHADE[100], dtype="<U7")
    for percent in sorted(_BOUNDS, reverse=True):
        colours[middle <= np.percentile(error, percent)] = _SHADE[percent]
    axes.bar(middle, share, width=np.diff(edges), color=list(colours))


def _mark_bounds(axes: "Axes", error: np.ndarray, published: Mapping[str, float]) -> None:
    for percent, (name, style) in _BOUNDS.items():
        if error.size:
            value = np.percentile(error, percent)
            label = f"{name} of all {value:.2f} px"
            axes.axvline(value, color="black", linestyle=style, linewidth=1.2, label=label)
    for name, value in published.items():
        axes.axvline(value, color="black", linestyle=":", label=f"published {name} {value:.2f} px")


def _cumulate(axes: "Axes", error: np.ndarray, name: str, colour: str, *, style: str = "-") -> None:
    if error.size:
        # A thousand points draw the curve as well as half a million.
        percent = np.linspace(0, 100, 1001)
        axes.plot(
            np.percentile(error, percent), percent, color=colour, label=name, linewidth=1.6, linestyle=style
        )
