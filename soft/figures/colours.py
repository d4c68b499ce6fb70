"""Colours of figures: even steps that everyone can tell apart, or the look of the paper."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.colors import Colormap


@dataclass(frozen=True)
class Colours:
    """Which colours a figure is drawn in.

    Attributes
    ----------
    speed, direction, error, signed : str
        Colour maps, by the names of cmcrameri or matplotlib: of magnitudes, of angles (cyclic), of errors,
        and of quantities around 0.
    interface, interface_casing : str
        The shear interface, and the thin line around it that sets it off.
    agree, disagree : str
        Segments where two methods agree, and where they do not (Fig. 11).
    arrow : str
        Arrows over a map.
    """

    speed: str
    direction: str
    error: str
    signed: str
    interface: str
    interface_casing: str
    agree: str
    disagree: str
    arrow: str


COLOURS = {
    # Scientific colour maps (Crameri 2018): even steps, read by those who do not tell red from green, in
    # order when printed in grey.
    "even": Colours(
        speed="batlow",
        direction="romaO",
        error="lajolla_r",
        signed="vik",
        interface="#e6007e",
        interface_casing="white",
        agree="#0060d0",
        disagree="#d9230f",
        arrow="black",
    ),
    # As Skonieczny et al. (2014) print them: blue at rest to red at the fastest, hue by direction.
    "paper": Colours(
        speed="jet",
        direction="hsv",
        error="jet",
        signed="seismic",
        interface="black",
        interface_casing="white",
        agree="blue",
        disagree="red",
        arrow="black",
    ),
}


def find_colours(name: str) -> Colours:
    """Colours by name, `even` or `paper`.

    Raises
    ------
    ValueError
        If there are none of this name.
    """
    if name not in COLOURS:
        raise ValueError(f"colours: {name!r}: allowed are {', '.join(COLOURS)}")
    return COLOURS[name]


def colour_map(name: str) -> "Colormap":
    """A colour map of cmcrameri or, where that has none of this name, of matplotlib."""
    import matplotlib
    from cmcrameri.cm import cmaps

    return cmaps[name] if name in cmaps else matplotlib.colormaps[name]
