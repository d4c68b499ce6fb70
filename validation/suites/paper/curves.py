"""Curves of the suite `paper`: distributions, growth, gains, directions, each beside what is published."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.published import read_published

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BLUE, _ORANGE, _GREEN, _GREY = "#0072b2", "#d55e00", "#009e73", "0.45"
"""Three of Okabe and Ito's, told apart by those who do not tell red from green."""
_SHADES = ("#4c78a8", "#b5cbe3", "#e3e3e3")
_LETTERS = 9
_HEIGHT = 3.3
"""Of a figure, inches."""
_SHOWN = 0.6
"""px of error that distributions are drawn to."""


def _page(columns: int = 1, *, width: float = 4.6, **options: Any) -> "tuple[Figure, list[Axes]]":
    from matplotlib.figure import Figure

    from soft.figures.page import plain_axes

    figure = Figure(figsize=(width * columns, _HEIGHT), layout="constrained")
    drawn = figure.subplots(1, columns, squeeze=False, **options)[0]
    return figure, [plain_axes(axes) for axes in drawn]


def _name(axes: "Axes", x: str, y: str, title: str = "") -> None:
    axes.set_xlabel(x, fontsize=_LETTERS)
    axes.set_ylabel(y, fontsize=_LETTERS)
    axes.set_title(title, fontsize=_LETTERS + 1, loc="left")


def _legend(axes: "Axes", **options: Any) -> None:
    axes.legend(edgecolor="none", framealpha=0.85, fontsize=_LETTERS - 1, **options)


def draw_distributions(counts: Mapping[tuple[str, str], np.ndarray]) -> "Figure":
    """Distribution of the error for each soil, with its bounds and the published ones (Figs. 8, 9).

    `counts` has, for each soil and severity, pixels by motion and error, over the edges of
    `validation.suites.paper.rotation`.
    """
    from validation.suites.paper.rotation import ERROR_EDGES

    soils = list(dict.fromkeys(soil for soil, _ in counts))
    figure, every = _page(len(soils), sharey=True)
    edges = ERROR_EDGES[:-1]
    published = read_published("rotation")
    for axes, soil in zip(every, soils, strict=True):
        for (own, severity), counted in counts.items():
            if own == soil:
                _distribution(axes, edges, counted.sum(axis=0), severity, shaded=severity == "paper")
        for name, says in (("median", "median"), ("p95", "95 %")):
            told = published[name]
            axes.axvspan(told.low, told.high, color="black", alpha=0.12, linewidth=0)
            axes.axvline(
                told.value,
                color="black",
                linestyle=":",
                linewidth=1.2,
                label=f"published {says} {told.value:.2f} px",
            )
        axes.set_xlim(0, _SHOWN)
        _name(axes, "error [px]", "pixels a 0.005 px [%]", f"{soil}")
        _legend(axes)
    return figure


def _distribution(
    axes: "Axes", edges: np.ndarray, counted: np.ndarray, severity: str, *, shaded: bool
) -> None:
    share = 100 * counted[:-1] / counted.sum()
    median, bound = (percentile_of(counted, edges, percent) for percent in (50, 95))
    label = f"{severity}: median {median:.2f}, 95 % {bound:.2f} px"
    if not shaded:
        axes.stairs(share, edges, color=_ORANGE, linewidth=1.2, label=label)
        return
    middle = (edges[:-1] + edges[1:]) / 2
    colours = [_SHADES[int(np.searchsorted((median, bound), x))] for x in middle]
    axes.bar(middle, share, width=np.diff(edges), color=colours)
    axes.plot([], [], color=_SHADES[0], linewidth=6, label=label)


def percentile_of(counted: np.ndarray, edges: np.ndarray, percent: float) -> float:
    """Percentile of a histogram whose last bin is open, within bins by a straight line."""
    cumulated = np.append(0.0, np.cumsum(counted)) / max(counted.sum(), 1)
    return float(np.interp(percent / 100, cumulated[:-1], edges))


def draw_growth(counts: Mapping[tuple[str, str], np.ndarray]) -> "Figure":
    """Error against the motion's magnitude, with the published slope."""
    from validation.suites.paper.rotation import ERROR_EDGES, MOTION_EDGES

    figure, (axes,) = _page(width=6.4)
    edges, middle = ERROR_EDGES[:-1], (MOTION_EDGES[:-1] + MOTION_EDGES[1:]) / 2
    slope = read_published("rotation")["slope_of_error_on_motion"].value
    chosen = {soil: counted for (soil, severity), counted in counts.items() if severity == "paper"}
    for (soil, counted), colour in zip(chosen.items(), (_BLUE, _ORANGE), strict=False):
        held = counted.sum(axis=1) > 0
        for percent, style in ((50, "-"), (95, "--")):
            curve = [percentile_of(row, edges, percent) for row in counted[held]]
            label = f"{soil}, {'median' if percent == 50 else '95 %'}"
            axes.plot(middle[held], curve, style, color=colour, marker="o", markersize=3, label=label)
    if chosen:
        counted = next(iter(chosen.values()))
        pixels = counted.sum(axis=1)
        centre = float(np.average(middle, weights=pixels))
        mean = percentile_of(counted.sum(axis=0), edges, 50)
        axes.plot(
            middle[pixels > 0],
            mean + slope * (middle[pixels > 0] - centre),
            ":",
            color="black",
            label="published slope",
        )
    axes.set_ylim(0, 1.35 * axes.get_ylim()[1])
    _name(axes, "motion [px]", "error [px]")
    _legend(axes, ncols=2, loc="upper center")
    return figure


def draw_camera(series: "xr.Dataset") -> "Figure":
    """The camera's motion of every pair, as measured and true, with the published range."""
    published = read_published("paper_speed")
    scale = float(series.attrs["speed_scale"])
    figure, (axes,) = _page(width=6.4)
    pairs = np.arange(1, series.sizes["pair"] + 1)
    middle, half = 7.23, published["range"].value
    axes.axhspan(
        middle - half, middle + half, color="black", alpha=0.08, linewidth=0, label="published 95 % range"
    )
    axes.plot(pairs, -series["speed_true"], color="black", linewidth=1.0, label="true")
    axes.plot(
        pairs,
        -series["speed_by_soil"],
        color=_ORANGE,
        linewidth=1.2,
        label="median of the true motion of soil",
    )
    axes.plot(pairs, -series["speed_measured"], "o", color=_BLUE, markersize=4, label="measured")
    there_and_back = (lambda px: np.multiply(px, scale), lambda speed: np.divide(speed, scale))
    axes.secondary_yaxis("right", functions=there_and_back).set_ylabel("[cm/s]", fontsize=_LETTERS)
    axes.locator_params(axis="x", integer=True)
    _name(axes, "pair of pictures", "camera's motion [px/frame]")
    _legend(axes)
    return figure


def draw_disagreements(rows: Mapping[str, np.ndarray]) -> "Figure":
    """Bars for each kind of flow: share that disagrees, and share of it at which SIFT is the worse one."""
    from validation.suites.paper.sift import WHERE

    figure, every = _page(2, width=4.4)
    titles = ("disagreement of all features [%]", "of those, SIFT farther off [%]")
    wide = 0.8 / len(rows)
    colours = (_BLUE, "#7fb8d8", _ORANGE, "#eeb48c", _GREEN, _GREY)
    for column, (axes, title) in enumerate(zip(every, titles, strict=True)):
        for k, (name, table) in enumerate(rows.items()):
            places = np.arange(len(WHERE)) + (k - (len(rows) - 1) / 2) * wide
            axes.bar(places, 100 * table[:, column], wide, color=colours[k % len(colours)], label=name)
        axes.set_xticks(range(len(WHERE)), WHERE)
        _name(axes, "flow, by the truth", title)
    every[0].set_ylim(0, 1.35 * every[0].get_ylim()[1])
    every[0].legend(frameon=False, fontsize=_LETTERS - 1, ncols=2, loc="upper center")
    return figure


def draw_gains(curves: "Mapping[str, xr.Dataset]") -> "Figure":
    """Error of means over N pairs, against the truth, with what independent errors would do."""
    figure, (axes,) = _page(width=6.4)
    for (wheel, one), colour in zip(curves.items(), (_BLUE, _ORANGE), strict=False):
        count, error = (one[f"averaging_true_{name}"].values for name in ("count", "error"))
        axes.plot(count, error, "o-", color=colour, markersize=4, label=f"{wheel} wheel")
        axes.plot(count, error[0] / np.sqrt(count), "--", color=colour, linewidth=1.0)
    axes.plot([], [], "--", color=_GREY, label="independent errors")
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    longest = max((one["averaging_true_count"].values for one in curves.values()), key=len)
    axes.set_xticks(longest, [str(n) for n in longest])
    low, high = axes.get_ylim()
    steps = (0.005, 0.007, 0.01, 0.015, 0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2, 0.3, 0.5, 0.7, 1.0)
    ticks = [tick for tick in steps if low <= tick <= high]
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()
    _name(axes, "pairs averaged, N", "error, root mean square [px]")
    _legend(axes)
    return figure


def draw_directions(spreads: Mapping[str, Mapping[str, np.ndarray]]) -> "Figure":
    """Roses of directions, one for each wheel: as measured and in truth."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.0 * len(spreads), 3.9), layout="constrained")
    every = figure.subplots(1, len(spreads), squeeze=False, subplot_kw={"projection": "polar"})[0]
    for axes, (wheel, ways) in zip(every, spreads.items(), strict=True):
        for way, share in ways.items():
            edges = np.linspace(-np.pi, np.pi, len(share) + 1)
            middle = (edges[:-1] + edges[1:]) / 2
            if way == "measured":
                axes.bar(middle, 100 * share, np.diff(edges), color=_BLUE, alpha=0.75, label=way)
            else:
                ring = np.append(np.arange(len(share)), 0)
                axes.plot(middle[ring], 100 * share[ring], color=_ORANGE, linewidth=1.6, label=way)
        axes.set_xticks(np.arange(4) * np.pi / 2, ["right", "up", "left", "down"], fontsize=_LETTERS)
        axes.tick_params(labelsize=_LETTERS - 1)
        axes.yaxis.get_major_locator().base.set_params(nbins=4)
        axes.set_rlabel_position(-67.5)
        axes.set_title(f"{wheel}: pixels a 10 degrees [%]", fontsize=_LETTERS + 1)
    every[-1].legend(frameon=False, fontsize=_LETTERS - 1, loc="lower left", bbox_to_anchor=(0.85, -0.1))
    return figure


def draw_trade_off(curves: Mapping[str, Sequence[tuple[float, float]]]) -> "Figure":
    """95 % error against vectors a picture; the last point of each curve is the dense technique's."""
    published = read_published("paper_piv")
    figure, (axes,) = _page(width=6.4)
    for (severity, points), colour in zip(curves.items(), (_BLUE, _ORANGE), strict=False):
        if len(points) > 1:
            count, error = np.array(points).T
            axes.plot(count[:-1], error[:-1], "o-", color=colour, label=f"PIV, severity {severity}")
            axes.plot(count[-1:], error[-1:], "D", color=colour, label=f"soft-2014, severity {severity}")
    told = (
        (250, published["coarse"].value, "<"),
        (2500, published["fine"].value, "^"),
        (1e6, published["every_pixel"].value, "v"),
    )
    for count, error, marker in told:
        axes.plot(count, error, marker, color="black", markerfacecolor="none", markersize=8)
    axes.plot(
        [], [], "^", color="black", markerfacecolor="none", label="published: PIV of White et al.; technique"
    )
    axes.set_xscale("log")
    axes.set_yscale("log")
    _name(axes, "vectors a picture", "95 % error [px]")
    _legend(axes)
    return figure
