"""A calibrated soil as a TOML file that says where its numbers come from, as JSON, and in a few lines."""

import re
import tomllib
from collections.abc import Iterable
from typing import Any

from synth.soil import SoilFile
from validation.calibration.biaxial import WINDOW, BiaxialPoint
from validation.calibration.calibrate import Calibration
from validation.calibration.plate import WIDTH

SCHEMA_VERSION = 1
_COMMENT_COLUMN = 34


def soil_text(source: str, calibration: Calibration) -> str:
    """The soil's file with the numbers found in place of the old ones, and the evidence behind them.

    Comments and everything else of the source stay as they are.

    Parameters
    ----------
    source : str
        Text of the file that was calibrated.
    """
    contact, found = calibration.soil.contact, calibration.found
    text = _without_tables(source, ("packing", "evidence"))
    text = _with_number(
        text,
        "rolling_friction",
        contact.rolling_friction,
        f"calibrated: a peak friction angle of {found.angle:.1f} deg, see [evidence]",
    )
    text = (
        text.rstrip() + "\n\n" + "\n".join([*_packing_lines(calibration), "", *_evidence_lines(calibration)])
    )
    _require_same(text, calibration)
    return text + "\n"


def _require_same(text: str, calibration: Calibration) -> None:
    """The file must read back as what was found, whatever the source looked like."""
    read = SoilFile.model_validate(tomllib.loads(text)).soil
    if read != calibration.soil:
        raise ValueError("soil: its file could not be rewritten; write [contact] with one key a line")


def _without_tables(text: str, names: Iterable[str]) -> str:
    """Text without these tables and their sub-tables."""
    kept, skipping = [], False
    for line in text.splitlines():
        header = re.match(r"\s*\[+\s*([\w-]+)", line)
        if header:
            skipping = header.group(1) in names
        if not skipping:
            kept.append(line)
    return "\n".join(kept)


def _with_number(text: str, key: str, value: float, comment: str) -> str:
    """Text with another number, and its reason, at a key that stands in it once."""
    return re.sub(rf"(?m)^{key}\s*=.*$", _number(key, value, comment), text, count=1)


def _number(key: str, value: float, comment: str) -> str:
    return f"{key} = {value!r}".ljust(_COMMENT_COLUMN) + f"# {comment}"


def _list(key: str, values: Iterable[float], comment: str = "") -> str:
    line = f"{key} = [{', '.join(f'{value:.4g}' for value in values)}]"
    return f"{line}  # {comment}" if comment else line


def _packing_lines(calibration: Calibration) -> list[str]:
    packing = calibration.soil.packing
    assert packing is not None
    return [
        "[packing]                         # measured: discs settled in a bin of 30 by 30 diameters",
        _number("polydispersity", packing.polydispersity, "of the discs"),
        _number("rolling_friction", packing.rolling_friction, "of the discs"),
        _number("restitution", packing.restitution, "of the discs"),
        _list("friction", packing.friction, "between the discs while they settle"),
        _list("void_ratio", packing.void_ratio, "measured at each: densest to loosest"),
    ]


def _evidence_lines(calibration: Calibration) -> list[str]:
    target, found, plate = calibration.target, calibration.found, calibration.plate
    law = plate.fit()
    lines = [
        "# Friction between grains is that of their material, as given above; rolling friction, which stands",
        "# for their shape, was searched for. One angle does not fix a pair: another friction has another",
        "# rolling friction. Angles are peaks of biaxial compression of discs in plane strain, stiffness /",
        "# pressure 1000. The grains' density makes the bed's bulk density the soil's (discs pack denser).",
        "[evidence]",
        _number(
            "relative_density",
            round(target.relative_density, 4),
            "aimed at: bulk_density between the published ends",
        ),
        _number("published_friction_angle", round(target.friction_angle, 2), "deg, aimed at"),
        _number("found_friction_angle", round(found.angle, 2), "deg, the nearest of those tried"),
        _number("standard_error", round(found.angle_error, 2), f"deg, of {len(found.sine)} seeds"),
        _number("bulk_density_measured", round(plate.bulk_density, 1), "kg/m3, of the plate's beds at rest"),
        _number(
            "bekker_exponent",
            round(law.exponent, 3),
            "n in pressure = k sinkage^n; nothing published at hand",
        ),
        _number("bekker_modulus", float(f"{law.modulus:.4g}"), "Pa/m^n, k = kc/b + kphi of this plate"),
        "",
    ]
    for point in calibration.tried:
        lines += _point_lines(point, "tried")
    lines += _point_lines(calibration.loosest, "loosest, not fitted")
    lines += _point_lines(calibration.densest, "densest, not fitted")
    return [
        *lines,
        "[evidence.plate]",
        _number("width", WIDTH, "m, of the plate"),
        _list("sinkage", plate.sinkage[3::4], "m"),
        _list("pressure", plate.pressure[3::4], "Pa, mean of the beds"),
        _list("spread", plate.spread[3::4], "Pa, standard deviation between beds"),
    ]


def _point_lines(point: BiaxialPoint, role: str) -> list[str]:
    return [
        f"[[evidence.biaxial]]              # {role}",
        _number("friction", point.friction, "between grains"),
        _number("rolling_friction", point.rolling_friction, "between grains"),
        _number("relative_density", round(point.relative_density, 4), "aimed at"),
        _number("friction_angle", round(point.angle, 2), "deg, of the mean sine"),
        _number("standard_error", round(point.angle_error, 2), "deg"),
        _list("sine", point.sine, f"peak of means over a strain of {WINDOW}, by seed"),
        _list("void_ratio", point.void_ratio, "before compression, by seed"),
        "",
    ]


def calibration_document(calibration: Calibration) -> dict[str, Any]:
    """The JSON document of `softbed calibrate`."""
    target, found, relation, plate = (
        calibration.target,
        calibration.found,
        calibration.relation,
        calibration.plate,
    )
    law = plate.fit()
    points = [*calibration.tried, calibration.loosest, calibration.densest]
    return {
        "schema_version": SCHEMA_VERSION,
        "soil": calibration.soil.name,
        "friction": calibration.soil.contact.friction,
        "rolling_friction": calibration.soil.contact.rolling_friction,
        "relative_density": target.relative_density,
        "friction_angle": {
            "published": target.friction_angle,
            "found": found.angle,
            "standard_error": found.angle_error,
        },
        "void_ratio": {"smallest": relation.smallest, "largest": relation.largest},
        "bulk_density": {"wanted": calibration.soil.bulk_density, "measured": plate.bulk_density},
        "biaxial": [_point_document(point) for point in points],
        "plate": {
            "width": WIDTH,
            "sinkage": list(plate.sinkage),
            "pressure": list(plate.pressure),
            "spread": list(plate.spread),
            "bekker_exponent": law.exponent,
            "bekker_modulus": law.modulus,
        },
    }


def _point_document(point: BiaxialPoint) -> dict[str, Any]:
    return {
        "friction": point.friction,
        "rolling_friction": point.rolling_friction,
        "relative_density": point.relative_density,
        "friction_angle": point.angle,
        "standard_error": point.angle_error,
        "sine": list(point.sine),
        "void_ratio": list(point.void_ratio),
    }


def calibration_lines(calibration: Calibration) -> str:
    """The same for a person, in short."""
    target, found, plate = calibration.target, calibration.found, calibration.plate
    law, contact, relation = plate.fit(), calibration.soil.contact, calibration.relation
    loosest, densest = calibration.loosest.angle, calibration.densest.angle
    return "\n".join(
        [
            f"friction {contact.friction}, rolling friction {contact.rolling_friction}",
            f"friction angle at relative density {target.relative_density:.2f}: {found.angle:.1f} "
            f"+- {found.angle_error:.1f} deg, published {target.friction_angle:.1f}",
            f"loosest, densest (not fitted): {loosest:.1f}, {densest:.1f} deg",
            f"void ratio, densest to loosest: {relation.smallest:.3f} to {relation.largest:.3f}",
            f"bulk density, kg/m3: {plate.bulk_density:.0f}, wanted {calibration.soil.bulk_density:.0f}",
            f"plate of {1e3 * WIDTH:.0f} mm: Bekker n = {law.exponent:.2f}, k = {law.modulus:.3g} Pa/m^n",
        ]
    )
