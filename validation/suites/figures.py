"""Figures of a suite: each a `matplotlib.figure.Figure` of its own, no global state."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from soft.figures.page import plain_axes
from validation.scoring.error_profile import MOMENTS, RANGES, percentile, share_above
from validation.scoring.metrics import WRONG_ABOVE
from validation.scoring.modulation import response

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_COLOURS = ("#4c78a8", "#e45756", "#54a24b", "#b07d2b", "#7b5ea7", "#3a9c9c", "0.35", "#d670a8")
_MARKERS = "osD^vP*X"
_FEWEST = 200
"""Pixels; a bin with fewer says nothing."""
_WRONG = WRONG_ABOVE[0]
_WORST_ERROR = (0.03, 10.0)


def draw_heat_map(
    shares: Mapping[str, np.ndarray], scenes: Sequence[str], methods: Sequence[str]
) -> "Figure":
    """Share of wrong pixels: a panel a stratum, a line a scene, a column a method.

    Parameters
    ----------
    shares : mapping
        For each stratum (scene, method), NaN where there is none.
    """
    from cmcrameri import cm
    from matplotlib.figure import Figure

    size = (max(6.4, 2.6 + 0.62 * len(methods) * len(shares)), 1.9 + 0.34 * len(scenes))
    figure = Figure(figsize=size, layout="constrained")
    row = figure.subplots(1, len(shares), sharey=True, squeeze=False)[0]
    for axes, (stratum, values) in zip(row, shares.items(), strict=True):
        image = axes.imshow(100 * values, cmap=cm.lajolla_r, vmin=0, vmax=60, aspect="auto")
        axes.set_title(stratum)
        axes.set_xticks(range(len(methods)), methods, rotation=45, ha="right")
        axes.set_yticks(range(len(scenes)), scenes)
        axes.tick_params(length=0)
        for (y, x), value in np.ndenumerate(100 * values):
            if np.isfinite(value):
                dark = value > 30
                axes.text(
                    x,
                    y,
                    f"{value:.0f}" if value >= 9.95 else f"{value:.1f}",
                    color="white" if dark else "black",
                    ha="center",
                    va="center",
                    fontsize=8,
                )
    figure.colorbar(image, ax=list(row), label=f"wrong by more than {_WRONG} px [%]", extend="max", pad=0.01)
    return figure


_NAME_LENGTH, _NAME_HEIGHT = 1.6, 0.15
"""About the ratio of times, and the share of a value, that a method's name takes up beside its point."""


def draw_cost(points: Mapping[str, tuple[float, float, float, float]], *, label: str) -> "Figure":
    """Error against time.

    Parameters
    ----------
    points : mapping
        For each method: seconds a pair, value, low and high end of its interval (NaN without).
    label : str
        Of the value.
    """
    from matplotlib.figure import Figure
    from matplotlib.patheffects import withStroke

    figure = Figure(figsize=(6.4, 4.0), layout="constrained")
    axes = plain_axes(figure.subplots())
    axes.set_xscale("log")
    for number, (method, (seconds, value, low, high)) in enumerate(points.items()):
        bars = None if np.isnan(low) else [[max(value - low, 0)], [max(high - value, 0)]]
        colour, marker = _style(number)
        axes.errorbar(seconds, value, yerr=bars, color=colour, marker=marker, capsize=3, markersize=7)
        taken = any(_is_covered(other, seconds, value) for other in points.values())
        axes.annotate(
            method,
            (seconds, value),
            xytext=(-7, 5) if taken else (7, 5),
            ha="right" if taken else "left",
            textcoords="offset points",
            fontsize=9,
            # Other methods' bars may cross the name.
            path_effects=[withStroke(linewidth=3, foreground="white")],
            zorder=5,
        )
    axes.set_ylim(0)
    axes.margins(x=0.25)
    axes.set_xlabel("time a picture pair, one thread [s]")
    axes.set_ylabel(label)
    return figure


def _is_covered(other: tuple[float, ...], seconds: float, value: float) -> bool:
    """Whether a name to the right of a point would lie upon another one."""
    return 1 < other[0] / seconds < _NAME_LENGTH and abs(other[1] / value - 1) < _NAME_HEIGHT


def draw_profiles(profiles: "Mapping[str, xr.Dataset]", quantity: str) -> "Figure":
    """Error against everything that may explain it, a panel each, a line a method.

    Parameters
    ----------
    profiles : mapping
        An error profile for each method.
    quantity : {"median", "wrong", "bias", "random"}
        Median error; share wrong by more than 0.3 px or not measured; mean and standard deviation of the
        error along the true motion.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13, 6.4), layout="constrained")
    grid = figure.subplots(2, 4).ravel()
    for axes, (name, explanation) in zip(grid, RANGES.items(), strict=False):
        plain_axes(axes)
        places = np.arange(len(explanation.edges) - 1)
        labels = [range_label(explanation.edges, k) for k in range(len(explanation.edges) - 1)]
        for number, (method, profile) in enumerate(profiles.items()):
            values = _QUANTITIES[quantity](profile, name)
            known = np.isfinite(values)
            colour, marker = _style(number)
            axes.plot(
                places[known],
                values[known],
                color=colour,
                marker=marker,
                markersize=4,
                linewidth=1.4,
                label=method,
            )
        axes.set_xticks(places, labels, rotation=45, ha="right")
        axes.tick_params(labelsize=8)
        axes.set_xlim(-0.5, len(places) - 0.5)
        axes.set_xlabel(f"{explanation.meaning} [{explanation.unit}]", fontsize=9)
        if quantity != "bias":
            axes.set_ylim(0)
    for axes in grid[::4]:
        axes.set_ylabel(_LABELS[quantity])
    legend = grid[len(RANGES)]
    legend.axis("off")
    handles, labels = grid[0].get_legend_handles_labels()
    legend.legend(handles, labels, loc="center", frameon=False)
    return figure


_LABELS = {
    "median": "median error [px]",
    "wrong": f"wrong by more than {_WRONG} px [%]",
    "bias": "bias along the motion [px]",
    "random": "random error along it [px]",
}


def _median(profile: "xr.Dataset", name: str) -> np.ndarray:
    counts = profile[f"count_{name}"].values
    return np.where(counts.sum(axis=1) >= _FEWEST, percentile(counts, 0.5), np.nan)


def _wrong(profile: "xr.Dataset", name: str) -> np.ndarray:
    counts, unmeasured = profile[f"count_{name}"].values, profile[f"unmeasured_{name}"].values
    measured = counts.sum(axis=1)
    total = measured + unmeasured
    wrong = unmeasured + measured * np.nan_to_num(share_above(counts, _WRONG))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(total >= _FEWEST, 100 * wrong / total, np.nan)


def _bias(profile: "xr.Dataset", name: str) -> np.ndarray:
    number, along, _, _, _ = _moments(profile, name)
    return np.where(number >= _FEWEST, along, np.nan)


def _random(profile: "xr.Dataset", name: str) -> np.ndarray:
    number, along, _, squared, _ = _moments(profile, name)
    return np.where(number >= _FEWEST, np.sqrt(np.maximum(squared - along**2, 0)), np.nan)


def _moments(profile: "xr.Dataset", name: str) -> list[np.ndarray]:
    """The number, and means over it of the other moments."""
    sums = profile[f"sums_{name}"].values
    number = sums[:, MOMENTS.index("number")]
    with np.errstate(invalid="ignore", divide="ignore"):
        return [number, *(sums[:, k] / number for k in range(1, len(MOMENTS)))]


_QUANTITIES = {"median": _median, "wrong": _wrong, "bias": _bias, "random": _random}


def draw_response(responses: "Mapping[str, xr.Dataset]") -> "Figure":
    """Share of an alternating strain's amplitude that each method tells, against its period."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.4, 4.0), layout="constrained")
    axes = plain_axes(figure.subplots())
    axes.set_xscale("log")
    for number, (method, sums) in enumerate(responses.items()):
        colour, marker = _style(number)
        axes.plot(
            sums["period"],
            response(sums),
            color=colour,
            marker=marker,
            markersize=4,
            linewidth=1.4,
            label=method,
        )
    axes.axhline(0.9, color="0.5", linewidth=0.8, linestyle=":")
    axes.axhline(0.5, color="0.5", linewidth=0.8, linestyle=":")
    axes.set_xticks([20, 30, 50, 100, 200, 300], labels=["20", "30", "50", "100", "200", "300"])
    axes.minorticks_off()
    axes.set_ylim(0)
    axes.set_xlabel("period [px]")
    axes.set_ylabel("share of the amplitude that is told")
    axes.legend(frameon=False, fontsize=9)
    return figure


# Places of the panels, shares of the figure: to find them anew for each of a hundred takes half the time.
_WORST_LEFT = (0.01, 0.315, 0.655)
_WORST_PANEL = (0.2742, 0.78)


def draw_worst(place: "xr.Dataset", *, top: float) -> "Figure":
    """Picture, true speed and error around the place where a method fails most."""
    from cmcrameri import cm
    from matplotlib.colors import LogNorm
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.4, 2.25))
    picture = place["worst_picture"].values
    low, high = _WORST_ERROR
    titles = "picture", "true speed [px]", "error [px]"
    row = [figure.add_axes((left, 0.06, *_WORST_PANEL)) for left in _WORST_LEFT]
    for axes, title in zip(row, titles, strict=True):
        axes.imshow(picture, cmap="gray", vmin=0, vmax=255)
        axes.set_axis_off()
        axes.set_title(title, fontsize=9)
    speed = row[1].imshow(place["worst_speed"].values, cmap=cm.batlow, vmin=0, vmax=top)
    error = np.maximum(place["worst_error"].values, low)
    image = row[2].imshow(error, cmap=cm.lajolla_r, norm=LogNorm(low, high))
    width, height = _WORST_PANEL
    beside = [figure.add_axes((left + width + 0.008, 0.06, 0.014, height)) for left in _WORST_LEFT[1:]]
    figure.colorbar(speed, cax=beside[0])
    bar = figure.colorbar(image, cax=beside[1], extend="both")
    bar.set_ticks([0.1, 1, 10], labels=["0.1", "1", "10"])
    return figure


def range_label(edges: Sequence[float], k: int) -> str:
    """What a bin of an explanation is called on an axis."""
    return f"> {edges[k]:g}" if np.isinf(edges[k + 1]) else f"{edges[k]:g}-{edges[k + 1]:g}"


def _style(number: int) -> tuple[str, str]:
    return _COLOURS[number % len(_COLOURS)], _MARKERS[number % len(_MARKERS)]
