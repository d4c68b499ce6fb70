"""Pages: sizes, axes, colour bars and wheels that every figure shares, and writing one to a file.

Each figure is a `matplotlib.figure.Figure` of its own; nothing global is touched, so figures work without a
display and side by side.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from soft.figures.colours import Colours, colour_map
from soft.figures.view import Extent, View

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import LineCollection
    from matplotlib.figure import Figure
    from matplotlib.image import AxesImage

SUFFIXES = (".png", ".pdf", ".svg")

# inch. The text width of a printed page, so that letters keep their size in print.
PAGE_WIDTH = 7.0
DOTS_PER_INCH = 200
LETTERS = 9  # points
_OVERLAY_OPACITY = 0.9
_INTERFACE_WIDTH = 1.4
_FAINT_BLACK = -350.0

# inch, around each panel: for the y labels, for a colour bar or wheel, for the title, for the x labels.
_LEFT, _BESIDE, _ABOVE, _BELOW = 0.62, 1.14, 0.3, 0.5
_BETWEEN_ROWS, _BETWEEN_COLUMNS = 0.16, 0.1
_MARGIN = 0.15
_TALLEST = 4.2
_BAR_GAP, _BAR_WIDTH = 0.09, 0.14
_WHEEL_CENTRE, _WHEEL_SIZE = 0.58, 0.56
_ARROWS_ACROSS = 26
_LOGARITHMIC_TICKS = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1, 3, 10, 30, 100)


_Place = tuple[float, float, float, float]


class FigureError(ValueError):
    """A figure that cannot be drawn or written; the message is one line."""


def save_figure(figure: "Figure", path: str | Path, *, dots_per_inch: int = DOTS_PER_INCH) -> Path:
    """Write a figure as PNG, PDF or SVG, by the suffix of `path`; equal figures give equal bytes.

    Raises
    ------
    FigureError
        If the suffix is another.
    """
    import matplotlib

    path = Path(path)
    suffix = require_suffix(path)
    # Neither date nor version; letters as letters, so that they can be searched and changed.
    nameless = {".png": {"Software": None}, ".pdf": {"CreationDate": None}, ".svg": {"Date": None}}
    letters: Any = {"pdf.fonttype": 42, "svg.fonttype": "none", "svg.hashsalt": "softbed"}
    with matplotlib.rc_context(letters):
        figure.savefig(path, dpi=dots_per_inch, metadata=nameless[suffix])
    return path


def require_suffix(path: Path, allowed: Sequence[str] = SUFFIXES) -> str:
    """The suffix of a file to write, by default a figure's.

    Raises
    ------
    FigureError
        If it is none of those allowed.
    """
    suffix = path.suffix.lower()
    if suffix not in allowed:
        raise FigureError(f"{path}: suffix {suffix!r}: allowed are {', '.join(allowed)}")
    return suffix


def new_page(
    shape: tuple[int, ...], *, rows: int = 1, columns: int = 1, width: float = PAGE_WIDTH, beside: bool = True
) -> "tuple[Figure, np.ndarray]":
    """A page with a grid of axes for pictures of one shape, and room for a colour bar or wheel beside each.

    Parameters
    ----------
    shape : (H, W)
        Of the pictures.
    rows, columns : int, optional
        Of the grid.
    width : float, optional
        Of the page, inch; less where the pictures are tall.
    beside : bool, optional
        False: no colour bar or wheel will stand beside the pictures.

    Returns
    -------
    figure : Figure
    grid : (rows, columns) array of Axes
        Only the outer ones have labels, as all show the same places.
    """
    from matplotlib.figure import Figure

    room = _BESIDE if beside else _MARGIN
    rest = _LEFT + columns * room + (columns - 1) * _BETWEEN_COLUMNS
    across = (width - rest) / columns
    tall = min(across * shape[0] / shape[1], _TALLEST)
    across = tall * shape[1] / shape[0]
    step_x, step_y = across + room + _BETWEEN_COLUMNS, tall + _ABOVE + _BETWEEN_ROWS
    size = (rest + columns * across, rows * step_y + _BELOW - _BETWEEN_ROWS)
    figure = Figure(figsize=size)
    grid = np.empty((rows, columns), object)
    for row, column in np.ndindex(rows, columns):
        left, bottom = _LEFT + column * step_x, size[1] - row * step_y - _ABOVE - tall
        axes = figure.add_axes(_share(size, left, bottom, across, tall))
        axes.tick_params(labelsize=LETTERS - 1, labelbottom=row == rows - 1, labelleft=column == 0)
        grid[row, column] = axes
    return figure, grid


def _share(size: Any, left: float, bottom: float, across: float, tall: float) -> "_Place":
    """A place in inches as shares of the page."""
    return left / size[0], bottom / size[1], across / size[0], tall / size[1]


def _beside(axes: "Axes", left: float, bottom: float, across: float, tall: float, **options: Any) -> "Axes":
    """New axes beside others; inches from their lower right corner."""
    figure = _page_of(axes)
    size = figure.get_size_inches()
    corner = axes.get_position(original=True)
    place = _share(size, corner.x1 * size[0] + left, corner.y0 * size[1] + bottom, across, tall)
    return figure.add_axes(place, **options)


def _height(axes: "Axes") -> float:
    """Of axes, inch."""
    return axes.get_position(original=True).height * _page_of(axes).get_size_inches()[1]


def _page_of(axes: "Axes") -> "Figure":
    """The whole page."""
    return cast("Figure", axes.figure)


def show_picture(
    axes: "Axes",
    picture: np.ndarray,
    extent: Extent,
    length_name: str,
    *,
    title: str = "",
    faint: bool = False,
) -> "AxesImage":
    """Show a picture (h, w), grey 0-255, with labelled axes; faint: bright, so that colours stand out."""
    black = _FAINT_BLACK if faint else 0
    shown = axes.imshow(picture, cmap="gray", vmin=black, vmax=255, extent=extent, interpolation="nearest")
    if axes.xaxis.get_tick_params()["labelbottom"]:
        axes.set_xlabel(f"x [{length_name}]", fontsize=LETTERS)
    if axes.yaxis.get_tick_params()["labelleft"]:
        axes.set_ylabel(f"y, down [{length_name}]", fontsize=LETTERS)
    axes.set_title(title, fontsize=LETTERS + 1, loc="left")
    axes.set_xlim(extent[0], extent[1])
    axes.set_ylim(extent[2], extent[3])
    return shown


def show_map(
    axes: "Axes",
    values: np.ndarray,
    extent: Extent,
    *,
    colours: str,
    low: float | None = None,
    high: float | None = None,
    norm: Any = None,
    opacity: float = _OVERLAY_OPACITY,
) -> "AxesImage":
    """Lay values (h, w) over a picture, from `low` to `high` or by a `norm`; NaN shows the picture."""
    scale = {"norm": norm} if norm is not None else {"vmin": low, "vmax": high}
    # Nearest: colours between two directions, or across the edge of what was measured, were never measured.
    return axes.imshow(
        values, cmap=colour_map(colours), extent=extent, alpha=opacity, interpolation="nearest", **scale
    )


def colour_bar(axes: "Axes", image: "AxesImage", label: str, *, extend: str = "neither") -> Any:
    """A bar beside the axes that says what colours mean."""
    from matplotlib.colors import LogNorm

    place = _beside(axes, _BAR_GAP, 0, _BAR_WIDTH, _height(axes))
    bar = axes.figure.colorbar(image, cax=place, extend=extend)
    if isinstance(image.norm, LogNorm):
        low, high = image.get_clim()
        plain = [mark for mark in _LOGARITHMIC_TICKS if (low or 0) <= mark <= (high or 0)]
        bar.set_ticks(plain, labels=[f"{mark:g}" for mark in plain])
        bar.minorticks_off()
    bar.set_label(label, fontsize=LETTERS)
    bar.ax.tick_params(labelsize=LETTERS - 1)
    return bar


def colour_wheel(axes: "Axes", colours: str) -> "Axes":
    """A ring beside the axes: the colour at an angle is that of motion towards it."""
    half = _WHEEL_SIZE / 2
    bottom = _height(axes) / 2 - half
    wheel = _beside(axes, _WHEEL_CENTRE - half, bottom, _WHEEL_SIZE, _WHEEL_SIZE, projection="polar")
    angle = np.linspace(-np.pi, np.pi, 181)
    values = np.broadcast_to((angle[:-1] + angle[1:]) / 2, (1, 180))
    wheel.pcolormesh(
        angle,
        np.array([0.55, 1.0]),
        values,
        cmap=colour_map(colours),
        vmin=-np.pi,
        vmax=np.pi,
        rasterized=True,
    )
    wheel.set_ylim(0, 1)
    wheel.set_yticks([])
    wheel.set_xticks([])
    for name, turn in (("right", 0.0), ("up", 0.5), ("left", 1.0), ("down", 1.5)):
        side = {"right": "left", "left": "right"}.get(name, "center")
        wheel.text(
            turn * np.pi, 1.12, name, fontsize=LETTERS - 2, ha=side,
            va={"up": "bottom", "down": "top"}.get(name, "center"),
        )  # fmt: skip
    wheel.grid(visible=False)
    wheel.spines["polar"].set_visible(False)
    return wheel


def draw_interface(axes: "Axes", view: View, colours: Colours, *, named: bool = True) -> None:
    """Draw the shear interface, or say that nothing moves; `named` puts it into a legend."""
    if not view.moving.any():
        note(axes, "no moving region found")
        return
    if view.lines is not None:
        interface_lines(axes, [view.units.length * line for line in view.lines], colours)
    elif not view.moving.all():  # a region that fills the picture has no boundary within it
        # Where soil ends, at the implement or in the air, it does not shear against soil.
        moving = np.where(view.soil, view.moving, np.nan)
        outline = axes.contour(*view.places, moving, levels=[0.5], colors=[colours.interface])
        outline.set(linewidths=_INTERFACE_WIDTH, path_effects=_cased(colours))
    if named:
        axes.plot([], [], color=colours.interface, linewidth=_INTERFACE_WIDTH, label="shear interface")
        axes.legend(loc="lower left", framealpha=0.9, fontsize=LETTERS - 1)


def interface_lines(axes: "Axes", lines: Sequence[np.ndarray], colours: Colours) -> "LineCollection":
    """Draw lines (N, 2), in the length unit, as a shear interface; others may be set later."""
    from matplotlib.collections import LineCollection

    drawn = LineCollection(
        lines, colors=colours.interface, linewidths=_INTERFACE_WIDTH, path_effects=_cased(colours)
    )
    axes.add_collection(drawn, autolim=False)
    return drawn


def _cased(colours: Colours) -> Any:
    """A thin rim around a line, which sets it off from any colour."""
    from matplotlib.patheffects import Normal, Stroke

    return [Stroke(linewidth=_INTERFACE_WIDTH + 1.4, foreground=colours.interface_casing), Normal()]


def draw_arrows(axes: "Axes", view: View, colours: Colours) -> None:
    """Draw arrows of one length where soil goes: the vectors at every n-th place of the moving region."""
    step = max(view.moving.shape[1] // _ARROWS_ACROSS, 1)
    every = slice(step // 2, None, step)
    here = (every, every)
    x, y = np.meshgrid(*(place[every] for place in view.places))
    with np.errstate(invalid="ignore"):
        chosen = view.moving[here] & (view.speed[here] > 0)
    length = view.speed[here][chosen]
    axes.quiver(
        x[chosen], y[chosen], view.x[here][chosen] / length, view.z[here][chosen] / length,
        # An arrow that points up has a positive second component on the screen, however y is counted.
        angles="uv", color=colours.arrow, pivot="mid", scale=1.35 * _ARROWS_ACROSS, width=0.0022,
        headwidth=4.5,
    )  # fmt: skip


def note(axes: "Axes", words: str, *, right: bool = False) -> None:
    """Say something in the lower left corner, or the right one."""
    x, side = (0.98, "right") if right else (0.02, "left")
    box = {"facecolor": "white", "alpha": 0.9, "edgecolor": "none"}
    axes.text(x, 0.04, words, ha=side, transform=axes.transAxes, bbox=box, fontsize=LETTERS - 1)


def plain_axes(axes: "Axes") -> "Axes":
    """Axes of a curve: no frame above and beside, a faint grid behind."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(color="0.9", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=LETTERS - 1)
    return axes
