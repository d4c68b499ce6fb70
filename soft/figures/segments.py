"""Two methods beside each other at points that one of them follows (Fig. 11)."""

from typing import TYPE_CHECKING, Protocol

import numpy as np

from soft.figures.colours import Colours, find_colours
from soft.figures.page import new_page, note, show_picture
from soft.figures.units import Units
from soft.figures.view import extent_of, smoothed, stride_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Segments are drawn this many times as long as the motion, if that leaves the longest below a 25th of the
# picture: motion from a picture to the next is short.
_LENGTHENINGS = (1, 2, 5, 10)
_LONGEST = 0.04


class Compared(Protocol):
    """What is drawn of a cross-validation."""

    points: np.ndarray  # (N, 2) x, y px
    sift: np.ndarray  # (N, 2) u, v px
    flow: np.ndarray  # (N, 2) u, v px
    agree: np.ndarray  # (N,) bool
    threshold: float  # px
    match_count: int
    agreement: float  # share


def segments_figure(
    compared: Compared,
    picture: np.ndarray,
    *,
    metres_per_pixel: float | None = None,
    colours: str = "even",
) -> "Figure":
    """Show motion at key points as SIFT follows them, above what the flow says there (Fig. 11).

    In the camera's frame. Segments start at a point and end where it goes, drawn longer by a stated factor
    where motion is short; blue where both agree within the threshold, red and thicker where they do not.

    Parameters
    ----------
    compared : CrossValidation
        Points and both motions, px.
    picture : (H, W) array
        The first picture, grey, 0-255.
    metres_per_pixel : float, optional
        Pixel size in m: axes in mm then.
    colours : str, optional
        `even` or `paper`.
    """
    chosen = find_colours(colours)
    units = Units.of(metres_per_pixel=metres_per_pixel, frame_rate=None)
    factor = _lengthening(compared.sift, picture.shape)
    figure, grid = new_page(picture.shape, rows=2, beside=False)
    extent, shown = extent_of(picture.shape, units), smoothed(picture, stride_of(picture.shape))
    drawn = "" if factor == 1 else f", drawn {factor} times as long"
    for axes, motion, name in zip(grid[:, 0], (compared.sift, compared.flow), ("SIFT", "Flow"), strict=True):
        title = f"{name}: motion at {compared.match_count} key points{drawn}"
        show_picture(axes, shown, extent, units.length_name, title=title, faint=True)
        _draw_segments(axes, compared, motion * factor, units.length, chosen)
    note(grid[1, 0], f"{compared.agreement:.1%} agree within {compared.threshold:g} px")
    _explain(grid[0, 0], chosen)
    return figure


def _lengthening(motion: np.ndarray, shape: tuple[int, ...]) -> int:
    length = np.hypot(motion[:, 0], motion[:, 1])
    usual = float(np.percentile(length, 95)) if length.size else 0.0
    fitting = [factor for factor in _LENGTHENINGS if factor * usual <= _LONGEST * shape[1]]
    return max(fitting, default=1)


def _draw_segments(
    axes: "Axes", compared: Compared, motion: np.ndarray, scale: float, colours: Colours
) -> None:
    from matplotlib.collections import LineCollection

    segments = scale * np.stack([compared.points, compared.points + motion], axis=1)
    for agree, colour, width in ((True, colours.agree, 0.7), (False, colours.disagree, 1.4)):
        chosen = segments[compared.agree == agree]
        axes.add_collection(LineCollection(list(chosen), colors=colour, linewidths=width), autolim=False)


def _explain(axes: "Axes", colours: Colours) -> None:
    from matplotlib.lines import Line2D

    lines = [
        Line2D([], [], color=colours.agree, linewidth=1.2, label="both agree"),
        Line2D([], [], color=colours.disagree, linewidth=2.0, label="they do not"),
    ]
    axes.legend(handles=lines, loc="lower left", framealpha=0.9, fontsize=8)
