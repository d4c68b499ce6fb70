"""The figures that an analysis ends with."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from soft.figures.motion import direction_figure, picture_figure, speed_figure
from soft.figures.page import save_figure
from soft.sequence import ImageSequence
from soft.shear_interface import shear_interface_of

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure


def write_figures(
    flow: "xarray.Dataset",
    sequence: ImageSequence,
    folder: str | Path,
    *,
    pair: int = 0,
    colours: str = "even",
) -> list[Path]:
    """Write picture, speed and direction of one pair as PNG and return their paths.

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
    colours : str, optional
        `even` or `paper`.

    Raises
    ------
    IndexError
        If there is no such pair.
    """
    pair = range(flow.sizes["pair"])[pair]
    frame = int(flow["first_frame"][pair])
    picture = sequence[frame]
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    scale = flow.attrs.get("metres_per_pixel")
    line = shear_interface_of(flow, pair=pair)
    makers: dict[str, Callable[[], Figure]] = {
        "picture": lambda: picture_figure(picture, metres_per_pixel=scale, title=f"Frame {frame}"),
        "speed": lambda: speed_figure(flow, picture, pair=pair, interface=line, colours=colours),
        "direction": lambda: direction_figure(flow, picture, pair=pair, interface=line, colours=colours),
    }
    return [save_figure(make(), folder / f"{name}-{pair:04d}.png") for name, make in makers.items()]
