"""What follows from soil flow: rates of deformation, streamlines, the velocity profile below a wheel."""

from typing import TYPE_CHECKING, Any

import numpy as np

from soft.figures.colours import find_colours
from soft.figures.motion import show_speed, title_of
from soft.figures.page import (
    LETTERS,
    FigureError,
    colour_bar,
    draw_interface,
    new_page,
    plain_axes,
    show_map,
    show_picture,
)
from soft.figures.view import View, reduced, stride_of, top_of, view_of_pair
from soft.pair_motion import motion_between_nodes

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from soft.averaging import MeanFlow
    from soft.shear_interface import ShearInterface
    from soft.soil_motion import VelocityProfile

# Attribute of a deformation: what it is called, and whether it has a sign.
QUANTITIES = {
    "shear": ("Shear rate", False),
    "rotation": ("Rotation rate, clockwise positive", True),
    "dilation": ("Dilation rate, loosening positive", True),
}
_LINE_WIDTH = 0.9
_ACROSS, _BELOW = "#0072b2", "#d55e00"


def deformation_figure(
    flow: "xarray.Dataset",
    picture: np.ndarray,
    *,
    quantity: str = "shear",
    pair: int = 0,
    interface: "ShearInterface | None" = None,
    colours: str = "even",
) -> "Figure":
    """Show how fast soil shears, turns or loosens.

    Parameters
    ----------
    flow : xarray.Dataset
        A SoilFlow.
    picture : (H, W) array
        The first picture of the pair, grey, 0-255.
    quantity : str, optional
        `shear`, `rotation` or `dilation`, as in `soft.deformation.Deformation`.
    pair : int, optional
        Which pair.
    interface : ShearInterface, optional
        The line between moving and resting soil; without it, the outline of `moving` stands for it.
    colours : str, optional
        `even` or `paper`.

    Raises
    ------
    FigureError
        If `quantity` is another word.
    """
    from soft.deformation import deformation_of

    if quantity not in QUANTITIES:
        raise FigureError(f"quantity: {quantity!r}: allowed are {', '.join(QUANTITIES)}")
    what, signed = QUANTITIES[quantity]
    chosen = find_colours(colours)
    view = view_of_pair(flow, picture, pair, interface)
    amount = getattr(deformation_of(flow, pair=pair), quantity)
    rate = view.units.rate * reduced(amount, stride_of(picture.shape))
    figure, grid = new_page(picture.shape)
    axes = grid[0, 0]
    show_picture(axes, view.picture, view.extent, view.units.length_name, title=title_of(what, flow, pair))
    top = top_of(np.abs(rate))
    scale: dict[str, Any] = (
        {"colours": chosen.signed, "low": -top} if signed else {"colours": chosen.speed, "low": 0}
    )
    image = show_map(axes, rate, view.extent, high=top, **scale)
    draw_interface(axes, view, chosen)
    unit = view.units.rate_name if quantity != "rotation" else f"rad{view.units.rate_name[1:]}"
    colour_bar(axes, image, f"{quantity} rate [{unit}]", extend="both" if signed else "max")
    return figure


def streamlines_figure(
    flow: "xarray.Dataset",
    picture: np.ndarray,
    *,
    pair: int = 0,
    spacing: float | None = None,
    interface: "ShearInterface | None" = None,
    colours: str = "even",
) -> "Figure":
    """Show lines along which soil moves, over its speed.

    `spacing` is how far lines keep from each other, px; a 40th of the picture's width by default. Other
    parameters are those of `deformation_figure`.
    """
    from soft.streamlines import trace_streamlines

    chosen = find_colours(colours)
    view = view_of_pair(flow, picture, pair, interface)
    motion = motion_between_nodes(flow, pair)
    spacing = spacing or max(picture.shape[1] / 40, 4.0)
    traced = trace_streamlines(motion.displacement, motion.moving, spacing=spacing)
    figure, grid = new_page(picture.shape)
    show_speed(grid[0, 0], view, chosen, title=title_of("Streamlines over soil speed", flow, pair))
    _draw_lines(grid[0, 0], [view.units.length * line for line in traced.lines])
    return figure


def _draw_lines(axes: "Axes", lines: list[np.ndarray]) -> None:
    """Lines with an arrow head in the middle of each, white on a dark rim: seen on any colour."""
    from matplotlib.collections import LineCollection
    from matplotlib.patheffects import Normal, Stroke

    rim = [Stroke(linewidth=_LINE_WIDTH + 1.0, foreground="black"), Normal()]
    drawn = LineCollection(lines, colors="white", linewidths=_LINE_WIDTH, path_effects=rim)
    axes.add_collection(drawn, autolim=False)
    for line in lines:
        if len(line) > 2:
            middle = len(line) // 2
            arrow = {"arrowstyle": "-|>", "color": "white", "lw": _LINE_WIDTH, "mutation_scale": 9}
            axes.annotate("", xy=line[middle + 1], xytext=line[middle - 1], arrowprops=arrow)


def profile_figure(
    flow: "xarray.Dataset",
    picture: np.ndarray,
    *,
    pair: int = 0,
    x: float | None = None,
    width: float = 11.0,
    colours: str = "even",
) -> "Figure":
    """Show how motion falls off with depth below a place, as under a wheel.

    Parameters
    ----------
    flow, picture, pair, colours
        As in `deformation_figure`.
    x : float, optional
        Column, px; by default where the soil's surface lies lowest, as below a wheel.
    width : float, optional
        Of the strip that is averaged over, px.

    Raises
    ------
    FigureError
        If there is no soil there.
    """
    from soft.soil_motion import velocity_profile

    motion = motion_between_nodes(flow, pair)
    x = _lowest_surface(motion.soil) if x is None else x
    try:
        profile = velocity_profile(motion.displacement, motion.soil, x=x, width=width)
    except ValueError as error:
        raise FigureError(str(error)) from error
    view = view_of_pair(flow, picture, pair)
    figure, grid = new_page(picture.shape, columns=2, width=10.0)
    title = title_of("Soil speed", flow, pair)
    show_speed(grid[0, 0], view, find_colours(colours), title=title, outlined=False)
    scale = view.units.length
    for side in (-width / 2, width / 2):
        grid[0, 0].plot(2 * [(x + side) * scale], profile.y[[0, -1]] * scale, color="white", linewidth=0.8)
    _draw_profile(grid[0, 1], profile, view)
    return figure


def _draw_profile(axes: "Axes", profile: "VelocityProfile", view: View) -> None:
    plain_axes(axes)
    units = view.units
    depth = units.length * profile.depth
    parts = (
        ("to the right", profile.u, profile.spread_u, _ACROSS),
        ("down", profile.v, profile.spread_v, _BELOW),
    )
    for name, mean, spread, colour in parts:
        middle, half = units.speed * mean, units.speed * spread
        axes.fill_betweenx(depth, middle - half, middle + half, color=colour, alpha=0.25, linewidth=0)
        axes.plot(middle, depth, color=colour, linewidth=1.4, label=name)
    axes.axvline(0, color="0.4", linewidth=0.8)
    axes.set_ylim(depth[-1], 0)
    axes.tick_params(labelleft=True)
    axes.set_xlabel(f"velocity [{units.speed_name}]", fontsize=LETTERS)
    axes.set_ylabel(f"depth [{units.length_name}]", fontsize=LETTERS)
    axes.set_title("Mean and spread below the surface", fontsize=LETTERS + 1, loc="left")
    axes.legend(frameon=False, fontsize=LETTERS - 1)


def gain_figure(mean: "MeanFlow") -> "Figure":
    """Show what averaging gains in signal-to-noise ratio, beside the square root of N (section 3.3).

    Parameters
    ----------
    mean : MeanFlow
        Flow averaged over pairs.

    Raises
    ------
    FigureError
        If there are too few pairs to tell.
    """
    from matplotlib.figure import Figure

    gain = mean.gain
    if not len(gain.pair_count):
        raise FigureError(f"average over {len(mean.pairs)} pair: at least 2 are needed to tell what it gains")
    figure = Figure(figsize=(4.6, 3.4), layout="constrained")
    axes = plain_axes(figure.subplots())
    count = gain.pair_count
    axes.plot(count, gain.ideal, color="black", linestyle="--", linewidth=1.2, label="square root of N")
    axes.plot(count, gain.gain, color=_ACROSS, marker="o", linewidth=1.6, label="measured")
    axes.set_xscale("log", base=2)
    axes.set_yscale("log", base=2)
    axes.set_xticks(count, [str(number) for number in count])
    ticks = [2.0**power for power in range(int(np.ceil(np.log2(gain.ideal[-1]))) + 1)]
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.set_xlabel("pairs averaged, N", fontsize=LETTERS)
    axes.set_ylabel("gain in signal-to-noise ratio", fontsize=LETTERS)
    axes.set_title(f"Averaging over {len(mean.pairs)} pairs", fontsize=LETTERS + 1, loc="left")
    axes.legend(frameon=False, fontsize=LETTERS - 1)
    return figure


def _lowest_surface(soil: np.ndarray) -> float:
    """The column whose uppermost soil lies lowest; the middle of several."""
    columns = np.flatnonzero(soil.any(axis=0))
    if not columns.size:
        raise FigureError("there is no soil in the picture")
    top = np.argmax(soil[:, columns], axis=0)
    return float(np.median(columns[top == top.max()]))
