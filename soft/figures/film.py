"""Films of a measurement: maps over the picture side by side, one page for each pair of pictures."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, repeat
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from soft.figures.colours import Colours, find_colours
from soft.figures.film_file import FILM_SUFFIXES, film_file
from soft.figures.page import (
    colour_bar,
    colour_wheel,
    interface_lines,
    new_page,
    require_suffix,
    show_map,
    show_picture,
)
from soft.figures.units import Units
from soft.figures.view import extent_of, reduced, stride_of, top_of, view_of_pair
from soft.sequence import ImageSequence
from soft.shear_interface import shear_interface_of

if TYPE_CHECKING:
    import xarray

Progress = Callable[[int, int], None]

# px across a film: what an ordinary screen shows whole. A gif compresses badly.
_PAGE_PIXELS = {".mp4": 1280, ".gif": 900}
_PAGE_WIDTH = 10.0  # inch
_SIDE_BY_SIDE = {1: (1, 1), 2: (1, 2), 3: (2, 2), 4: (2, 2)}
_UNCERTAINTY_RANGE = (0.01, 3.0)  # px
_USUAL_RATE = 8.0  # pictures a second, where the frame rate is unknown: that of the paper


@dataclass(frozen=True)
class Panel:
    """One part of the page.

    Attributes
    ----------
    title : str
        Above it.
    colours : str, optional
        Colour map of what lies over the picture; empty: nothing does.
    label : str, optional
        Beside the colour bar; empty: a colour wheel, as the values are angles.
    low, high : float, optional
        Ends of the colour scale, which is the same for all pictures.
    logarithmic : bool, optional
        Whether the scale is.
    """

    title: str
    colours: str = ""
    label: str = ""
    low: float = 0.0
    high: float = 1.0
    logarithmic: bool = False


@dataclass(frozen=True, eq=False)
class Shot:
    """One picture of the film.

    Attributes
    ----------
    label : str
        Frame and time.
    picture : (h, w) array
        Grey, 0-255.
    maps : sequence of (h, w) array or None
        What lies over the picture in each panel; NaN shows the picture.
    lines : sequence of sequence of (N, 2) array, optional
        The shear interface in each panel, px.
    """

    label: str
    picture: np.ndarray
    maps: Sequence[np.ndarray | None]
    lines: Sequence[Sequence[np.ndarray]] = ()


class FilmPage:
    """A page that is drawn again and again with other values.

    Parameters
    ----------
    panels : sequence of Panel
        One to four.
    shape : (h, w)
        Of the pictures as displayed.
    full_shape : (H, W)
        Of the pictures, px.
    units : Units
        Of the axes.
    pixels : int
        Width of the page, px.
    colours : Colours
        Of the shear interface.
    """

    def __init__(
        self,
        panels: Sequence[Panel],
        shape: tuple[int, int],
        full_shape: tuple[int, int],
        *,
        units: Units,
        pixels: int,
        colours: Colours,
    ) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        rows, columns = _SIDE_BY_SIDE[len(panels)]
        figure, grid = new_page(full_shape, rows=rows, columns=columns, width=_PAGE_WIDTH)
        figure.set_dpi(pixels / figure.get_figwidth())
        self._canvas = FigureCanvasAgg(figure)
        extent, empty = extent_of(full_shape, units), np.full(shape, np.nan)
        self._pictures, self._maps, self._lines = [], [], []
        self._length = units.length
        for panel, axes in zip(panels, grid.ravel(), strict=False):
            self._pictures.append(show_picture(axes, empty, extent, units.length_name, title=panel.title))
            self._maps.append(_empty_map(axes, panel, empty, extent))
            self._lines.append(interface_lines(axes, [], colours))
        for axes in grid.ravel()[len(panels) :]:
            axes.remove()
        self._title, self._first = grid[0, 0], panels[0].title

    def draw(self, shot: Shot) -> np.ndarray:
        """The page with these values, (height, width, 3) uint8, red, green, blue."""
        for shown in self._pictures:
            shown.set_data(shot.picture)
        for shown, values in zip(self._maps, shot.maps, strict=True):
            if shown is not None:
                shown.set_data(values)
        # Panels beyond those that lines are told for have none.
        for drawn, lines in zip(self._lines, chain(shot.lines, repeat(())), strict=False):
            drawn.set_segments([self._length * line for line in lines])
        self._title.set_title(f"{self._first}, {shot.label}", fontsize=10, loc="left")
        self._canvas.draw()
        return np.ascontiguousarray(np.asarray(self._canvas.buffer_rgba())[..., :3])


def _empty_map(axes: Any, panel: Panel, empty: np.ndarray, extent: Any) -> Any:
    from matplotlib.colors import LogNorm, Normalize

    if not panel.colours:
        return None
    norm = (LogNorm if panel.logarithmic else Normalize)(panel.low, panel.high)
    shown = show_map(axes, empty, extent, colours=panel.colours, norm=norm)
    if panel.label:
        colour_bar(axes, shown, panel.label, extend="both" if panel.logarithmic else "max")
    else:
        colour_wheel(axes, panel.colours)
    return shown


def write_film(
    path: str | Path,
    panels: Sequence[Panel],
    shots: Iterable[Shot],
    *,
    shape: tuple[int, int],
    units: Units,
    rate: float | None,
    count: int,
    colours: Colours,
    progress: Progress | None = None,
) -> None:
    """Write a film of pages, each drawn and written before the next one is asked for.

    Parameters
    ----------
    path : str or Path
        `.mp4` (VP9, for browsers) or `.gif`.
    panels : sequence of Panel
        What stands side by side.
    shots : iterable of Shot
        In order of time.
    shape : (H, W)
        Of the pictures, px.
    units : Units
        Of the axes.
    rate : float or None
        Pictures a second; eight where it is unknown.
    count : int
        How many there will be.
    colours : Colours
        Of the shear interface.
    progress : callable, optional
        Called with the pictures done and in all.

    Raises
    ------
    FigureError
        If the suffix is another, or the film cannot be written.
    """
    kind = require_suffix(Path(path), FILM_SUFFIXES)
    page = None
    with film_file(path, rate=rate or _USUAL_RATE, kind=kind) as film:
        for done, shot in enumerate(shots, start=1):
            if page is None:
                shown = (shot.picture.shape[0], shot.picture.shape[1])
                page = FilmPage(panels, shown, shape, units=units, pixels=_PAGE_PIXELS[kind], colours=colours)
            film.add(page.draw(shot))
            if progress is not None:
                progress(done, count)


def flow_film(
    flow: "xarray.Dataset",
    sequence: ImageSequence,
    path: str | Path,
    *,
    colours: str = "even",
    progress: Progress | None = None,
) -> None:
    """Write a film of a measurement: picture, speed, direction and, where it is told, uncertainty.

    The shear interface is drawn over speed and direction.

    Parameters
    ----------
    flow : xarray.Dataset
        A SoilFlow of `sequence`.
    sequence : ImageSequence
        The pictures it was measured on.
    path : str or Path
        `.mp4` (VP9, for browsers) or `.gif`.
    colours : str, optional
        `even` or `paper`.
    progress : callable, optional
        Called with the pairs done and in all.
    """
    chosen, units = find_colours(colours), Units.of_flow(flow)
    panels = [
        Panel("Picture"),
        speed_panel(flow, chosen, units, title=f"Speed ({flow.attrs['method']})"),
        direction_panel(chosen),
    ]
    if uncertain := bool(np.isfinite(flow["uncertainty_u"].isel(pair=0)).any()):
        low, high = _UNCERTAINTY_RANGE
        panels.append(Panel("Uncertainty, one sigma", chosen.error, "[px]", low, high, logarithmic=True))
    write_film(
        path, panels, _shots(flow, sequence, uncertain=uncertain), shape=sequence.shape, units=units,
        rate=sequence.frame_rate, count=flow.sizes["pair"], colours=chosen, progress=progress,
    )  # fmt: skip


def _shots(flow: "xarray.Dataset", sequence: ImageSequence, *, uncertain: bool) -> Iterator[Shot]:
    for pair in range(flow.sizes["pair"]):
        line = shear_interface_of(flow, pair=pair)
        view = view_of_pair(flow, sequence[int(flow["first_frame"][pair])], pair, line)
        maps: list[np.ndarray | None] = [None, view.speed, view.direction]
        if uncertain:
            maps.append(np.where(np.isfinite(view.x), _uncertainty(flow, pair), np.nan))
        yield Shot(label_of(flow, pair), view.picture, maps, ((), line.lines, line.lines))


def _uncertainty(flow: "xarray.Dataset", pair: int) -> np.ndarray:
    """Length of the standard uncertainty, (h, w) px as displayed."""
    part = flow[["uncertainty_u", "uncertainty_v"]].isel(pair=pair)
    length = np.hypot(part["uncertainty_u"].to_numpy(), part["uncertainty_v"].to_numpy())
    return reduced(length, stride_of(length.shape)).clip(_UNCERTAINTY_RANGE[0], None)


def speed_panel(flow: "xarray.Dataset", colours: Colours, units: Units, *, title: str) -> Panel:
    """A panel for the speeds of a SoilFlow; the scale is that of its middle pair."""
    pair = (flow.sizes["pair"] - 1) // 2
    arrays = flow[["inertial_u", "inertial_v", "valid", "soil"]].isel(pair=pair)
    speed = np.hypot(arrays["inertial_u"].to_numpy(), arrays["inertial_v"].to_numpy())
    top = units.speed * top_of(speed[(arrays["valid"] & arrays["soil"]).to_numpy()])
    return Panel(title, colours.speed, f"speed [{units.speed_name}]", 0.0, top)


def direction_panel(colours: Colours, *, title: str = "Direction") -> Panel:
    """A panel for directions."""
    return Panel(title, colours.direction, low=-np.pi, high=np.pi)


def label_of(flow: "xarray.Dataset", pair: int) -> str:
    """Frame and time of a pair in words."""
    first, second = int(flow["first_frame"][pair]), int(flow["second_frame"][pair])
    time = flow["time"]
    if time.attrs.get("units") != "s":
        return f"frames {first} to {second}"
    return f"frames {first} to {second}, {float(time[pair]):.3f} s"
