"""Truth beside measurement, and the error at each pixel (Figs. 6, 7)."""

from typing import TYPE_CHECKING

import numpy as np

from validation.figures.maps import show_error
from validation.pair_view import DIRECTION_ABOVE, Measured, Motion, PairView

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from soft.figures.view import View

_WIDTH = 10.0


def truth_figure(view: PairView, name: str, *, colours: str = "even") -> "Figure":
    """Show true beside measured motion, speed above direction, on one scale (Fig. 6).

    Parameters
    ----------
    view : PairView
        A pair with its truth.
    name : str
        Which of the methods in it.
    colours : str, optional
        `even` or `paper`.
    """
    from soft.figures.colours import find_colours
    from soft.figures.motion import show_direction, show_speed
    from soft.figures.page import new_page
    from soft.figures.view import top_of

    chosen = find_colours(colours)
    sides = {
        f"Truth, pair {view.pair}": as_seen(view.truth, view),
        f"Measured ({name})": as_seen(view.measured[name].motion, view),
    }
    top = top_of(*(side.speed for side in sides.values()))
    figure, grid = new_page(view.picture.shape, rows=2, columns=2, width=_WIDTH)
    for k, (title, side) in enumerate(sides.items()):
        last = k == 1
        show_speed(grid[0, k], side, chosen, title=f"{title}: speed", top=top, outlined=False, bar=last)
        show_direction(grid[1, k], side, chosen, title=f"{title}: direction", outlined=False, wheel=last)
    return figure


def error_figure(view: PairView, name: str, *, colours: str = "even") -> "Figure":
    """Show the error at each pixel of true soil (Fig. 7). Parameters are those of `truth_figure`."""
    from soft.figures.page import new_page, note, show_picture
    from soft.figures.view import extent_of

    measured = view.measured[name]
    extent = extent_of(view.picture.shape, view.units)
    figure, grid = new_page(view.picture.shape)
    title = f"Motion error, pair {view.pair} ({name})"
    show_picture(grid[0, 0], view.picture, extent, view.units.length_name, title=title, faint=True)
    show_error(grid[0, 0], measured, extent, colours=colours)
    note(grid[0, 0], _in_words(measured))
    return figure


def as_seen(motion: Motion, view: PairView) -> "View":
    """Motion as figures of measurements show it; moving is what is fast enough to have a direction."""
    from soft.figures.view import view_of_motion

    with np.errstate(invalid="ignore"):
        moving = motion.speed > DIRECTION_ABOVE
    soil = np.isfinite(motion.u)
    return view_of_motion(motion.u, motion.v, view.picture, soil=soil, moving=moving, units=view.units)


def _in_words(measured: Measured) -> str:
    error = measured.error[np.isfinite(measured.error)]
    if not error.size:
        return "nothing was measured"
    median, bound = np.percentile(error, [50, 95])
    words = f"half within {median:.2f} px, 95 % within {bound:.2f} px"
    missed = int(measured.missed.sum())
    return f"{words}; magenta: {missed} px not measured" if missed else words
