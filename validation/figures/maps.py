"""The report's maps over the picture: what the camera saw, motion, strata, error."""

import io
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.pair_view import Measured, Motion

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from soft.figures.view import Extent

_WIDTH = 6.4
_DOTS_PER_INCH = 150
ERROR_RANGE = (0.01, 3.0)
_MISSED = "#d62aa5"
STRATUM_COLOURS = {"quiet": "#0072b2", "moving": "#009e73", "complex": "#d55e00"}
"""Three of Okabe and Ito's, told apart by those who do not tell red from green."""


def to_png(figure: "Figure") -> bytes:
    """Encode a figure as PNG."""
    buffer = io.BytesIO()
    # Without the date and the version: equal figures, equal bytes.
    figure.savefig(buffer, format="png", dpi=_DOTS_PER_INCH, metadata={"Software": None})
    return buffer.getvalue()


def draw_picture(picture: np.ndarray) -> "Figure":
    """Show the picture as the camera took it; (H, W) grey levels 0-255."""
    from soft.figures import picture_figure

    return picture_figure(picture)


def draw_speed(motion: Motion, picture: np.ndarray, *, top: float) -> "Figure":
    """Speed in the inertial frame over the picture, from 0 to `top` px a frame."""
    from soft.figures.colours import COLOURS
    from soft.figures.page import colour_bar, show_map

    figure, axes, extent = _map_page(picture)
    image = show_map(axes, motion.speed, extent, colours=COLOURS["even"].speed, low=0, high=top, opacity=1)
    colour_bar(axes, image, "speed [px/frame]", extend="max")
    return figure


def draw_direction(motion: Motion, picture: np.ndarray) -> "Figure":
    """Direction in the inertial frame over the picture, where soil moves at all."""
    from soft.figures.colours import COLOURS
    from soft.figures.page import colour_wheel, show_map

    figure, axes, extent = _map_page(picture)
    colours = COLOURS["even"].direction
    show_map(axes, motion.shown_direction, extent, colours=colours, low=-np.pi, high=np.pi, opacity=1)
    colour_wheel(axes, colours)
    return figure


def draw_strata(strata: Mapping[str, np.ndarray], picture: np.ndarray) -> "Figure":
    """Which pixels are quiet, moving, and complex; (H, W) bool masks."""
    from matplotlib.patches import Patch

    figure, axes, extent = _map_page(picture)
    for name, colour in STRATUM_COLOURS.items():
        show_mask(axes, strata[name], extent, colour)
    patches = [Patch(color=colour, label=name) for name, colour in STRATUM_COLOURS.items()]
    axes.legend(handles=patches, loc="upper left", bbox_to_anchor=(1.01, 1), frameon=False, fontsize=9)
    return figure


def draw_error(measured: Measured, picture: np.ndarray) -> "Figure":
    """End-point error over true soil on a logarithmic scale; what was not measured is magenta."""
    figure, axes, extent = _map_page(picture)
    show_error(axes, measured, extent)
    return figure


def show_error(axes: "Axes", measured: Measured, extent: "Extent", *, colours: str = "even") -> Any:
    """Lay the end-point error over a picture; returns the image."""
    from matplotlib.colors import LogNorm

    from soft.figures.colours import find_colours
    from soft.figures.page import colour_bar, show_map

    low, high = ERROR_RANGE
    error = measured.shown(measured.error).clip(low, None)
    name = find_colours(colours).error
    image = show_map(axes, error, extent, colours=name, norm=LogNorm(low, high), opacity=1)
    if measured.missed.any():
        missed = measured.shown(np.where(measured.missed, 1.0, np.nan))
        show_mask(axes, np.isfinite(missed), extent, _MISSED)
    colour_bar(axes, image, "end-point error [px]", extend="both")
    return image


def show_mask(axes: "Axes", mask: np.ndarray, extent: "Extent", colour: str) -> None:
    """Paint where a mask is True."""
    from matplotlib.colors import ListedColormap

    painted = np.where(mask, 1.0, np.nan)
    axes.imshow(painted, cmap=ListedColormap([colour]), extent=extent, interpolation="nearest")


def _map_page(picture: np.ndarray) -> "tuple[Figure, Axes, Extent]":
    """A page with the picture, faint, so that colours stand out and what is not soil is recognized."""
    from soft.figures.page import new_page, show_picture
    from soft.figures.units import Units
    from soft.figures.view import extent_of

    figure, grid = new_page(picture.shape, width=_WIDTH)
    extent = extent_of(picture.shape, Units())
    show_picture(grid[0, 0], picture, extent, "px", faint=True)
    return figure, grid[0, 0], extent
