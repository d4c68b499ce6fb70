"""Figures of a drawbar test: the paper's Fig. 17 drawn anew, and who pushes in which phase."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from synth.rover.drawbar import DrawbarPoint
from validation.drawbar.curve import Curve
from validation.drawbar.document import published_maximum

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = {"rolling": "#4c78a8", "inching": "#e45756"}
_AXLES = {"front": "#b07d2b", "rear": "#54a24b"}
_MARKS = {"rigid": "o", "pneumatic": "^"}
_LINES = {"rft": "-", "bwj": "--", "scm": ":", "dem": "-."}


def travel_reduction_figure(curves: Sequence[Curve]) -> "Figure":
    """Travel reduction against drawbar pull over weight; the published maxima as bars at the top."""
    from matplotlib.figure import Figure

    from soft.figures.page import plain_axes

    figure = Figure(figsize=(7.0, 4.6), layout="constrained")
    axes = plain_axes(figure.subplots())
    for curve in curves:
        _draw_curve(axes, curve)
    drawn = set()
    for curve in curves:
        published = published_maximum(curve)
        if published is not None and curve.order.published_name not in drawn:
            drawn.add(curve.order.published_name)
            _mark_published(axes, curve, published)
    axes.set(
        xlabel="drawbar pull / vehicle weight", ylabel="travel reduction [%]", ylim=(-3, 118), xlim=(0, None)
    )
    axes.legend(frameon=False, fontsize=8, loc="upper left", bbox_to_anchor=(0.0, 0.93))
    return figure


def balance_figure(curves: Sequence[Curve]) -> "Figure":
    """Force of the soil on front and rear axle over the load, one panel for each curve and phase."""
    from matplotlib.figure import Figure

    from soft.figures.page import plain_axes

    panels = [(curve, mean.phase) for curve in curves for mean in curve.points[0].phases]
    columns = min(3, len(panels))
    rows = -(-len(panels) // columns)
    figure = Figure(figsize=(3.3 * columns, 2.7 * rows + 0.3), layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False, sharey=True).ravel()
    for axes, (curve, phase) in zip(grid, panels, strict=False):
        _draw_balance(plain_axes(axes), curve, phase)
    for axes in grid[len(panels) :]:
        axes.set_axis_off()
    grid[0].legend(frameon=False, fontsize=8)
    figure.supxlabel("drawbar pull / vehicle weight", fontsize=9)
    figure.supylabel("force of the soil on an axle / vehicle weight", fontsize=9)
    return figure


def _draw_curve(axes: "Axes", curve: Curve) -> None:
    order = curve.order
    pull = [point.drawbar_pull_ratio for point in curve.points]
    lost = [100 * point.travel_reduction for point in curve.points]
    axes.plot(
        pull, lost, _LINES.get(order.law, "-"), marker=_MARKS[order.wheel], markersize=4, linewidth=1.2,
        color=_COLOURS[order.gait], markerfacecolor="none" if order.wheel == "pneumatic" else None,
        label=f"{order.wheel}, {order.gait}, {order.law}: {curve.maximum:.3f}",
    )  # fmt: skip


def _mark_published(axes: "Axes", curve: Curve, published: float) -> None:
    colour = _COLOURS[curve.order.gait]
    axes.plot([published] * 2, [103, 109], color=colour, linewidth=2.5, solid_capstyle="butt")
    axes.annotate(
        f"{curve.order.wheel}\n{published:g}", (published, 109.5), ha="center", va="bottom", fontsize=7,
        color=colour, annotation_clip=False,
    )  # fmt: skip


def _draw_balance(axes: "Axes", curve: Curve, phase: str) -> None:
    points = curve.moving
    pull = np.array([point.drawbar_pull_ratio for point in points])
    for axle, colour in _AXLES.items():
        share = np.array([_axle_force(point, phase, axle) for point in points]) / curve.vehicle_weight
        axes.plot(pull, share, "o-", markersize=3, linewidth=1.2, color=colour, label=f"{axle} axle")
    axes.plot(pull, pull, color="black", linewidth=0.8, linestyle=":", label="cable")
    axes.axhline(0, color="black", linewidth=0.6)
    axes.set_title(f"{curve.order.wheel}, {curve.order.gait}: {_describe(phase)}", fontsize=8)


def _describe(phase: str) -> str:
    told = {
        "expand": "expand\n(front rolls, rear pushes)",
        "contract": "contract\n(rear rolls, front pushes)",
    }
    return told.get(phase, phase)


def _axle_force(point: DrawbarPoint, phase: str, axle: str) -> float:
    for mean in point.phases:
        if mean.phase == phase:
            return sum(wheel.force_x for wheel in mean.wheels if wheel.wheel.startswith(axle))
    return float("nan")
