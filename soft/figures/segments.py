"""Two methods beside each other at points that one of them follows (Fig. 11)."""

from typing import TYPE_CHECKING

import numpy as np

from soft.figures.colours import Colours, find_colours
from soft.figures.page import new_page, note, show_picture
from soft.figures.units import Units
from soft.figures.view import extent_of, smoothed, stride_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from soft.cross_validation import CrossValidation

# Motion from a picture to the next is short: segments are drawn this many times as long, as far as that
# leaves usual ones below a 25th of the picture and twice the way from a point to the next.
_LENGTHENINGS = (1, 2, 5, 10)
_LONGEST = 0.04
# A wrong match may leap across the picture: its segment is cut at this share of the picture's width.
_CUT = 0.12


def segments_figure(
    compared: "CrossValidation",
    picture: np.ndarray,
    *,
    metres_per_pixel: float | None = None,
    colours: str = "even",
) -> "Figure":
    """Show motion at key points as SIFT follows them, above what the flow says there (Fig. 11).

    In the camera's frame. Segments start at a point and end where it goes, drawn longer by a stated factor
    where motion is short; blue where both agree within the threshold, red and thicker where they do not. One
    that would be longer than an eighth of the picture is cut, and that is said.

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
    longest = _CUT * picture.shape[1]
    for axes, motion, name in zip(grid[:, 0], (compared.sift, compared.flow), ("SIFT", "Flow"), strict=True):
        title = f"{name}: motion at {len(compared.points)} key points{drawn}"
        show_picture(axes, shown, extent, units.length_name, title=title, faint=True)
        _draw_segments(axes, compared, _cut(motion * factor, longest), units.length, chosen)
    note(grid[1, 0], _in_words(compared))
    if cut := int((np.hypot(*(compared.sift * factor).T) > longest).sum()):
        note(grid[0, 0], f"{cut} segment{'s' if cut > 1 else ''} cut short", right=True)
    _explain(grid[0, 0], chosen)
    return figure


def _in_words(compared: "CrossValidation") -> str:
    matched = f"{compared.match_count} of {compared.keypoint_count} features matched"
    if not len(compared.points):
        return f"{matched}: nothing to compare"
    return f"{compared.agreement:.1%} agree within {compared.threshold:g} px; {matched}"


def _lengthening(motion: np.ndarray, shape: tuple[int, ...]) -> int:
    length = np.hypot(motion[:, 0], motion[:, 1])
    usual = float(np.percentile(length, 95)) if length.size else 0.0
    apart = float(np.sqrt(shape[0] * shape[1] / max(length.size, 1)))
    longest = min(_LONGEST * shape[1], 2 * apart)
    fitting = [factor for factor in _LENGTHENINGS if factor * usual <= longest]
    return max(fitting, default=1)


def _cut(motion: np.ndarray, longest: float) -> np.ndarray:
    """Vectors (N, 2) no longer than this."""
    length = np.hypot(motion[:, 0], motion[:, 1])
    return motion * (longest / np.maximum(length, longest))[:, None]


def _draw_segments(
    axes: "Axes", compared: "CrossValidation", motion: np.ndarray, scale: float, colours: Colours
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
