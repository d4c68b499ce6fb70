"""The laws there are, by name, with the soil of the published drawbar test."""

import math
from pathlib import Path
from typing import Literal

from synth.rover.law.pressure_sinkage import BekkerLaw, BekkerSoil, ColumnLaw
from synth.rover.law.response import SoilError, published_scale
from synth.rover.law.rft import ResistiveForceLaw, ResistiveSoil
from synth.rover.law.rim_law import RimLaw
from synth.text_files import checked, read_json_object

LAW_NAMES = ("rft", "bwj", "scm")
"""Resistive force theory; Bekker-Wong-Janosi; the latter on vertical columns."""
WHEEL_KINDS = ("rigid", "pneumatic")
_DENSITY, _FRICTION_ANGLE = 1620.0, 32.0
"""kg/m3 and deg, of loose GRC-1: its lower published density; assumed, from 30 to 33 deg."""
_SURFACE_FRICTION = 0.5
"""Assumed: a wheel covered with what it rolls on, as in the scenes."""
_STIFFNESS_RATIO = 5.0
"""Elastic stiffness / scale; assumed."""
_SHEAR_SHARE = 0.19
"""Of the elastic stiffness, along the surface: found on a real wheel in sand (docs/wheel_law.md)."""
_RUT_SHARE = 0.5
"""Of the sinkage, left as rut: seen behind the wheel in the granular bin."""
_BEKKER = BekkerSoil(
    modulus=564e3,
    exponent=0.776,
    friction=math.tan(math.radians(_FRICTION_ANGLE)),
    shear_modulus=0.01,
    stiffness=1e7,
)
"""Modulus and exponent: the plate pressed into the granular bin (scenes/soils/grc1.toml); K assumed."""
_LOAD, _WIDTH, _RADIUS, _DEFLECTION = 687.0, 0.18, 0.355, 0.02
"""N, m, m, m: the pneumatic wheel's deflection under its load on a rigid floor; assumed."""


def make_law(
    name: str,
    *,
    wheel: Literal["rigid", "pneumatic"] = "rigid",
    soil: ResistiveSoil | BekkerSoil | None = None,
) -> RimLaw:
    """A law by its name, its wheels yet to be placed.

    Parameters
    ----------
    soil : ResistiveSoil or BekkerSoil, optional
        Default: loose GRC-1.

    Raises
    ------
    SoilError
        There is no such law or wheel, or the soil is another law's.
    """
    if wheel not in WHEEL_KINDS:
        raise SoilError(f"wheel = {wheel!r}: allowed are {', '.join(WHEEL_KINDS)}")
    rim_stiffness = (
        None
        if wheel == "rigid"
        else pneumatic_stiffness(load=_LOAD, width=_WIDTH, radius=_RADIUS, deflection=_DEFLECTION)
    )
    if name == "rft":
        if soil is None:
            soil = loose_grc1()
        if not isinstance(soil, ResistiveSoil):
            raise SoilError(f"soil = {soil!r}: law 'rft' needs a ResistiveSoil")
        return ResistiveForceLaw(soil, rim_stiffness=rim_stiffness)
    kinds = {"bwj": BekkerLaw, "scm": ColumnLaw}
    if name not in kinds:
        raise SoilError(f"law = {name!r}: allowed are {', '.join(LAW_NAMES)}")
    if soil is None:
        soil = _BEKKER
    if not isinstance(soil, BekkerSoil):
        raise SoilError(f"soil = {soil!r}: law {name!r} needs a BekkerSoil")
    return kinds[name](soil, rim_stiffness=rim_stiffness)


def loose_grc1(
    *, friction_angle: float = _FRICTION_ANGLE, shear_share: float = _SHEAR_SHARE
) -> ResistiveSoil:
    """Loose GRC-1: scale by published density and friction angle (deg)."""
    scale = published_scale(density=_DENSITY, friction_angle=friction_angle)
    return ResistiveSoil(
        scale=scale,
        surface_friction=_SURFACE_FRICTION,
        stiffness=_STIFFNESS_RATIO * scale,
        shear_share=shear_share,
        rut_share=_RUT_SHARE,
    )


def pneumatic_stiffness(*, load: float, width: float, radius: float, deflection: float) -> float:
    """Pressure / deflection of a rim's elements, Pa/m, that lets the axle sink so far on a rigid flat floor.

    The rim gives way by deflection - x^2 / (2 radius) over the contact, so the load is width x stiffness x
    4/3 deflection x sqrt(2 radius deflection): for deflections that are small against the radius.
    """
    return load / (width * 4 / 3 * deflection * math.sqrt(2 * radius * deflection))


def read_soil(path: str | Path) -> ResistiveSoil:
    """Read the soil that `softbed identify` found: the table `soil` of its identification.json.

    Raises
    ------
    SoilError
        The file has no such table, or not the constants of a `ResistiveSoil`.
    """
    try:
        told = read_json_object(Path(path))
        if "soil" not in told:
            raise ValueError("soil: missing")
        return checked(ResistiveSoil, told["soil"], name="soil")
    except FileNotFoundError:
        raise SoilError(f"{path}: no such file") from None
    except ValueError as error:
        raise SoilError(f"{path}: the table 'soil' of softbed identify is needed: {error}") from None
