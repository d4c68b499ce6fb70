"""Figures of measurements: raw picture, speed and shear interface, direction and colour wheel (Fig. 4).

Each function returns a `matplotlib.figure.Figure` of its own; nothing global is touched, so they work without
a display and side by side. Large pictures are shown with every n-th pixel: displayed vectors are samples,
never averages of magnitudes.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from soft.sequence import ImageSequence
from soft.velocity import to_polar, to_velocity

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# More pixels than this a side are not told apart on a page.
DISPLAY_SIDE = 1400
FIGURE_WIDTH = 9.0
DOTS_PER_INCH = 160
OVERLAY_OPACITY = 0.8
INTERFACE_COLOUR = "#e6007e"

# The colour scale ends at this percentile of the speeds, as a few wrong vectors would set it otherwise.
TOP_PERCENTILE = 99.5


@dataclass(frozen=True, eq=False)
class _View:
    """One pair as displayed: every n-th pixel of picture and flow, and the extent in the axes' unit."""

    picture: np.ndarray
    u: np.ndarray
    z: np.ndarray
    shown: np.ndarray
    moving: np.ndarray
    unit: str
    extent: tuple[float, float, float, float]
    length_unit: str
    title: str


def picture_figure(
    picture: np.ndarray, *, metres_per_pixel: float | None = None, title: str = ""
) -> "Figure":
    """Show the raw picture with its scale.

    Parameters
    ----------
    picture : (H, W) array
        Grey, 0-255.
    metres_per_pixel : float, optional
        Pixel size in m: axes in mm then, in px otherwise.
    title : str, optional
        Above the picture.
    """
    extent, length_unit = _extent(picture.shape, metres_per_pixel)
    figure, axes = _empty_figure(picture.shape, extent, length_unit, title)
    _show_grey(axes, _reduced(picture, _stride(picture.shape)), extent)
    return figure


def speed_figure(flow: "xarray.Dataset", picture: np.ndarray, *, pair: int = 0) -> "Figure":
    """Show speed in the inertial frame over soil, with the outline of the moving region, the shear interface.

    Parameters
    ----------
    flow : xarray.Dataset
        A SoilFlow.
    picture : (H, W) array
        The first picture of the pair, grey, 0-255.
    pair : int, optional
        Which pair.
    """
    from cmcrameri.cm import cmaps

    view = _view(flow, picture, pair, "Soil speed")
    figure, axes = _empty_figure(picture.shape, view.extent, view.length_unit, view.title)
    _show_grey(axes, view.picture, view.extent)
    speed = np.where(view.shown, np.hypot(view.u, view.z), np.nan)
    # "batlow" has even steps and is read by those who do not tell red from green.
    image = axes.imshow(
        speed, cmap=cmaps["batlow"], vmin=0, vmax=_top(speed), extent=view.extent, alpha=OVERLAY_OPACITY
    )
    _outline(axes, view)
    figure.colorbar(image, ax=axes, label=f"speed [{view.unit}]", fraction=0.035, pad=0.02, extend="max")
    return figure


def direction_figure(flow: "xarray.Dataset", picture: np.ndarray, *, pair: int = 0) -> "Figure":
    """Show the direction of inertial motion within the moving region, with a colour wheel.

    Outside the moving region direction has little meaning and is left out. Parameters are those of
    `speed_figure`.
    """
    from cmcrameri.cm import cmaps

    view = _view(flow, picture, pair, "Direction of soil motion")
    figure, axes = _empty_figure(picture.shape, view.extent, view.length_unit, view.title)
    _show_grey(axes, view.picture, view.extent)
    _, direction = to_polar(view.u, view.z)
    shown = np.where(view.shown & view.moving, direction, np.nan)
    axes.imshow(
        shown, cmap=cmaps["romaO"], vmin=-np.pi, vmax=np.pi, extent=view.extent, alpha=OVERLAY_OPACITY
    )
    _outline(axes, view)
    _colour_wheel(axes, cmaps["romaO"])
    return figure


def write_figures(
    flow: "xarray.Dataset", sequence: ImageSequence, folder: str | Path, *, pair: int = 0
) -> list[Path]:
    """Write the figures of one pair as PNG and return their paths.

    Parameters
    ----------
    flow : xarray.Dataset
        A SoilFlow of `sequence`.
    sequence : ImageSequence
        The pictures it was measured on.
    folder : str or Path
        Is made if it is missing.
    pair : int, optional
        Which pair; negative ones count from the end.

    Raises
    ------
    IndexError
        If there is no such pair.
    """
    pair = range(flow.sizes["pair"])[pair]
    picture = sequence[int(flow["first_frame"][pair])]
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    makers: dict[str, Callable[[], Figure]] = {
        "picture": lambda: picture_figure(
            picture,
            metres_per_pixel=flow.attrs.get("metres_per_pixel"),
            title=f"Frame {int(flow['first_frame'][pair])}",
        ),
        "speed": lambda: speed_figure(flow, picture, pair=pair),
        "direction": lambda: direction_figure(flow, picture, pair=pair),
    }
    return [_saved(make(), folder / f"{name}-{pair:04d}.png") for name, make in makers.items()]


def _saved(figure: "Figure", path: Path) -> Path:
    figure.savefig(path, dpi=DOTS_PER_INCH)
    return path


def _view(flow: "xarray.Dataset", picture: np.ndarray, pair: int, what: str) -> _View:
    stride = _stride(picture.shape)
    part = {"pair": pair, "y": slice(stride // 2, None, stride), "x": slice(stride // 2, None, stride)}
    arrays = flow[["inertial_u", "inertial_v", "valid", "soil", "moving"]].isel(part)
    scale, unit = _speed_unit(flow)
    displacement = np.stack([arrays["inertial_u"].to_numpy(), arrays["inertial_v"].to_numpy()], axis=-1)
    x, z = to_velocity(displacement, metres_per_pixel=scale, time_step=1.0)
    extent, length_unit = _extent(picture.shape, flow.attrs.get("metres_per_pixel"))
    first, second = int(flow["first_frame"][pair]), int(flow["second_frame"][pair])
    return _View(
        picture=_reduced(picture, stride),
        u=x,
        z=z,
        shown=(arrays["valid"] & arrays["soil"]).to_numpy(),
        moving=arrays["moving"].to_numpy(),
        unit=unit,
        extent=extent,
        length_unit=length_unit,
        title=f"{what}, frames {first} to {second} ({flow.attrs['method']})",
    )


def _speed_unit(flow: "xarray.Dataset") -> tuple[float, str]:
    """Factor from px per frame, and the unit it leads to."""
    if "velocity_x" in flow:
        return flow.attrs["metres_per_pixel"] * flow.attrs["frame_rate"] * 1e3, "mm/s"
    return 1.0, "px per frame"


def _stride(shape: tuple[int, ...]) -> int:
    return -(-max(shape) // DISPLAY_SIDE)


def _reduced(picture: np.ndarray, stride: int) -> np.ndarray:
    import cv2

    size = tuple(len(range(stride // 2, side, stride)) for side in picture.shape)
    return cv2.resize(picture, size[::-1], interpolation=cv2.INTER_AREA) if stride > 1 else picture


def _extent(
    shape: tuple[int, ...], metres_per_pixel: float | None
) -> tuple[tuple[float, float, float, float], str]:
    """Left, right, bottom, top of the picture for `imshow`, y down, with pixel centres at whole px."""
    scale, unit = (1.0, "px") if metres_per_pixel is None else (metres_per_pixel * 1e3, "mm")
    height, width = shape
    return (-0.5 * scale, (width - 0.5) * scale, (height - 0.5) * scale, -0.5 * scale), unit


def _empty_figure(
    shape: tuple[int, ...], extent: tuple[float, ...], length_unit: str, title: str
) -> tuple["Figure", "Axes"]:
    from matplotlib.figure import Figure

    # Room beside the picture for a colour bar or wheel, within bounds for very flat or tall pictures.
    height = min(max(FIGURE_WIDTH * 0.82 * shape[0] / shape[1] + 1.0, 3.0), 12.0)
    figure = Figure(figsize=(FIGURE_WIDTH, height), layout="constrained")
    axes = figure.add_subplot()
    axes.set_xlabel(f"x [{length_unit}]")
    axes.set_ylabel(f"y, down [{length_unit}]")
    axes.set_title(title)
    axes.set_xlim(extent[0], extent[1])
    axes.set_ylim(extent[2], extent[3])
    return figure, axes


def _show_grey(axes: "Axes", picture: np.ndarray, extent: tuple[float, float, float, float]) -> None:
    axes.imshow(picture, cmap="gray", vmin=0, vmax=255, extent=extent)


def _top(speed: np.ndarray) -> float:
    finite = speed[np.isfinite(speed)]
    top = float(np.percentile(finite, TOP_PERCENTILE)) if finite.size else 0.0
    return top if top > 0 else 1.0


def _outline(axes: "Axes", view: _View) -> None:
    """Draw the moving region's boundary, or say that there is none."""
    if not view.moving.any():
        axes.text(
            0.02,
            0.03,
            "no moving region found",
            transform=axes.transAxes,
            bbox={"facecolor": "white", "alpha": 0.85, "edgecolor": "none"},
        )
        return
    # A region that fills the picture has no boundary within it.
    if not view.moving.all():
        left, right, bottom, top = view.extent
        rows, columns = view.moving.shape
        x = left + (np.arange(columns) + 0.5) * (right - left) / columns
        y = top + (np.arange(rows) + 0.5) * (bottom - top) / rows
        axes.contour(x, y, view.moving, levels=[0.5], colors=INTERFACE_COLOUR, linewidths=1.4)
    axes.plot([], [], color=INTERFACE_COLOUR, linewidth=1.4, label="shear interface")
    axes.legend(loc="lower left", framealpha=0.85)


def _colour_wheel(axes: "Axes", colours: Any) -> None:
    """Draw a ring beside the picture: the colour at an angle is that of motion towards it."""
    wheel = axes.inset_axes((1.07, 0.35, 0.14, 0.3), projection="polar")
    angle = np.linspace(-np.pi, np.pi, 181)
    radius = np.array([0.55, 1.0])
    values = np.broadcast_to((angle[:-1] + angle[1:]) / 2, (1, 180))
    wheel.pcolormesh(angle, radius, values, cmap=colours, vmin=-np.pi, vmax=np.pi)
    wheel.set_ylim(0, 1)
    wheel.set_yticks([])
    wheel.set_xticks([0, np.pi / 2, np.pi, 3 * np.pi / 2], ["right", "up", "left", "down"], fontsize=8)
    wheel.tick_params(pad=-1)
    wheel.grid(visible=False)
    wheel.spines["polar"].set_visible(False)
