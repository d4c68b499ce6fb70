"""Picture, speed and direction, alone and beside each other (Figs. 4, 10, 12, 13, 18, 19, 20)."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from soft.figures.colours import Colours, find_colours
from soft.figures.page import (
    colour_bar,
    colour_wheel,
    draw_arrows,
    draw_interface,
    new_page,
    show_map,
    show_picture,
)
from soft.figures.units import Units
from soft.figures.view import View, extent_of, smoothed, stride_of, top_of, view_of_motion, view_of_pair

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from soft.averaging import MeanFlow
    from soft.shear_interface import ShearInterface


def picture_figure(
    picture: np.ndarray, *, metres_per_pixel: float | None = None, title: str = ""
) -> "Figure":
    """Show the raw picture with its scale (Fig. 2).

    Parameters
    ----------
    picture : (H, W) array
        Grey, 0-255.
    metres_per_pixel : float, optional
        Pixel size in m: axes in mm then, in px otherwise.
    title : str, optional
        Above the picture.
    """
    units = Units.of(metres_per_pixel=metres_per_pixel, frame_rate=None)
    figure, grid = new_page(picture.shape, beside=False)
    shown = smoothed(picture, stride_of(picture.shape))
    show_picture(grid[0, 0], shown, extent_of(picture.shape, units), units.length_name, title=title)
    return figure


def speed_figure(
    flow: "xarray.Dataset",
    picture: np.ndarray,
    *,
    pair: int = 0,
    interface: "ShearInterface | None" = None,
    top: float | None = None,
    colours: str = "even",
) -> "Figure":
    """Show speed in the inertial frame over soil, with the shear interface (Figs. 4 top, 10).

    Parameters
    ----------
    flow : xarray.Dataset
        A SoilFlow.
    picture : (H, W) array
        The first picture of the pair, grey, 0-255.
    pair : int, optional
        Which pair.
    interface : ShearInterface, optional
        The line between moving and resting soil; without it, the outline of `moving` stands for it.
    top : float, optional
        Where the colour scale ends, in the unit of the figure; by default at the 99.5th percentile.
    colours : str, optional
        `even` (legible to all) or `paper`.
    """
    view, chosen = view_of_pair(flow, picture, pair, interface), find_colours(colours)
    figure, grid = new_page(picture.shape)
    show_speed(grid[0, 0], view, chosen, title=title_of("Soil speed", flow, pair), top=top)
    return figure


def direction_figure(
    flow: "xarray.Dataset",
    picture: np.ndarray,
    *,
    pair: int = 0,
    interface: "ShearInterface | None" = None,
    arrows: bool = False,
    colours: str = "even",
) -> "Figure":
    """Show the direction of inertial motion where soil moves, with a colour wheel (Figs. 4 bottom, 19).

    Outside the moving region direction has little meaning and is left out. `arrows` adds arrows of one
    length; other parameters are those of `speed_figure`.
    """
    view, chosen = view_of_pair(flow, picture, pair, interface), find_colours(colours)
    figure, grid = new_page(picture.shape)
    title = title_of("Direction of soil motion", flow, pair)
    show_direction(grid[0, 0], view, chosen, title=title, arrows=arrows)
    return figure


def motion_figure(
    flow: "xarray.Dataset",
    picture: np.ndarray,
    *,
    pair: int = 0,
    interface: "ShearInterface | None" = None,
    colours: str = "even",
) -> "Figure":
    """Show speed above direction (Fig. 4). Parameters are those of `speed_figure`."""
    view, chosen = view_of_pair(flow, picture, pair, interface), find_colours(colours)
    figure, grid = new_page(picture.shape, rows=2)
    show_speed(grid[0, 0], view, chosen, title=title_of("Soil speed", flow, pair))
    show_direction(grid[1, 0], view, chosen, title="Direction of soil motion", named=False)
    return figure


def bucket_figure(
    flow: "xarray.Dataset",
    picture: np.ndarray,
    *,
    pair: int = 0,
    interface: "ShearInterface | None" = None,
    colours: str = "even",
) -> "Figure":
    """Show where a tool pushes soil: direction with arrows, above its speed (Fig. 20).

    Parameters are those of `speed_figure`.
    """
    view, chosen = view_of_pair(flow, picture, pair, interface), find_colours(colours)
    figure, grid = new_page(picture.shape, rows=2)
    title = title_of("Direction of soil motion", flow, pair)
    show_direction(grid[0, 0], view, chosen, title=title, arrows=True)
    show_speed(grid[1, 0], view, chosen, title="Soil speed", named=False)
    return figure


def average_figure(
    flow: "xarray.Dataset",
    mean: "MeanFlow",
    picture: np.ndarray,
    *,
    pair: int = 0,
    interface: "ShearInterface | None" = None,
    colours: str = "even",
) -> "Figure":
    """Show the speed of a single pair beside that of the average over pairs, on one scale (Figs. 12, 13).

    Parameters
    ----------
    flow, picture, pair, colours
        As in `speed_figure`.
    mean : MeanFlow
        Averaged vectors in the implement's frame, inertial, px per pair.
    interface : ShearInterface, optional
        Of the average; without it, none is drawn.
    """
    chosen = find_colours(colours)
    single = view_of_pair(flow, picture, pair)
    averaged = mean_view(mean, picture, units=Units.of_flow(flow, pair), interface=interface)
    top = top_of(single.speed)
    figure, grid = new_page(picture.shape, rows=2)
    show_speed(grid[0, 0], single, chosen, title=title_of("Single pair", flow, pair), top=top, outlined=False)
    title = f"Average over {len(mean.pairs)} pairs"
    show_speed(grid[1, 0], averaged, chosen, title=title, top=top, outlined=interface is not None)
    return figure


def mean_view(
    mean: "MeanFlow", picture: np.ndarray, *, units: Units, interface: "ShearInterface | None" = None
) -> View:
    """Averaged flow as displayed; every pixel that has an average counts as moving soil."""
    shown = np.isfinite(mean.u) & np.isfinite(mean.v)
    return view_of_motion(mean.u, mean.v, picture, soil=shown, moving=shown, units=units, interface=interface)


def comparison_figure(
    runs: "Sequence[tuple[str, xarray.Dataset, np.ndarray]]",
    *,
    pair: int = 0,
    interfaces: "Sequence[ShearInterface | None] | None" = None,
    colours: str = "even",
) -> "Figure":
    """Show runs beside each other, speed above direction (Figs. 18, 19): rolling beside pushed, say.

    Every run has a speed scale of its own: where thrust differs, magnitudes do not compare, directions do.

    Parameters
    ----------
    runs : sequence of (str, xarray.Dataset, (H, W) array)
        What each is called, its SoilFlow, and the first picture of the pair.
    pair : int, optional
        Which pair of each.
    interfaces : sequence of ShearInterface or None, optional
        Of each.
    colours : str, optional
        `even` or `paper`.
    """
    chosen = find_colours(colours)
    interfaces = interfaces or [None] * len(runs)
    shape = max((picture.shape for _, _, picture in runs), key=lambda shape: shape[0] / shape[1])
    # A page turned on its side.
    figure, grid = new_page(shape, rows=2, columns=len(runs), width=10.0)
    last = len(runs) - 1
    pairs = zip(runs, interfaces, strict=True)
    views = [view_of_pair(flow, picture, pair, interface) for (_, flow, picture), interface in pairs]
    for k, ((name, _, _), view) in enumerate(zip(runs, views, strict=True)):
        if (view.extent, view.units) != (views[0].extent, views[0].units):
            # It does not share the first one's axis.
            for axes in grid[:, k]:
                axes.tick_params(labelleft=True)
        show_speed(grid[0, k], view, chosen, title=f"{name}: speed", named=k == 0)
        show_direction(grid[1, k], view, chosen, title=f"{name}: direction", named=False, wheel=k == last)
    return figure


def show_speed(
    axes: "Axes",
    view: View,
    colours: Colours,
    *,
    title: str,
    top: float | None = None,
    named: bool = True,
    outlined: bool = True,
    bar: bool = True,
) -> None:
    """Lay speed over the picture, with a colour bar and the shear interface."""
    show_picture(axes, view.picture, view.extent, view.units.length_name, title=title)
    speed = view.speed
    image = show_map(axes, speed, view.extent, colours=colours.speed, low=0, high=top or top_of(speed))
    if outlined:
        draw_interface(axes, view, colours, named=named)
    if bar:
        colour_bar(axes, image, f"speed [{view.units.speed_name}]", extend="max")


def show_direction(
    axes: "Axes",
    view: View,
    colours: Colours,
    *,
    title: str,
    named: bool = True,
    outlined: bool = True,
    arrows: bool = False,
    wheel: bool = True,
) -> None:
    """Lay direction over the picture, with the shear interface and a colour wheel."""
    show_picture(axes, view.picture, view.extent, view.units.length_name, title=title)
    show_map(axes, view.direction, view.extent, colours=colours.direction, low=-np.pi, high=np.pi)
    if outlined:
        draw_interface(axes, view, colours, named=named)
    if arrows:
        draw_arrows(axes, view, colours)
    if wheel:
        colour_wheel(axes, colours.direction)


def title_of(what: str, flow: "xarray.Dataset", pair: int) -> str:
    """A title that says which frames and which method."""
    first, second = int(flow["first_frame"][pair]), int(flow["second_frame"][pair])
    return f"{what}, frames {first} to {second} ({flow.attrs['method']})"
