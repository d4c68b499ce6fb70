"""Tables of docs/simulator.md."""

import tomllib
from typing import Any

from kept import Row, distinct, document, having

from synth.scene_files import scenes_folder
from validation.markdown_tables import markdown_table

SOILS = {"GRC-1": "grc1", "Fillite": "fillite"}


def soils() -> str:
    """What the calibration of the shipped soils aimed at and found, from their files."""
    columns = [_soil(name) for name in SOILS.values()]
    table = [[told, *(column[told] for column in columns)] for told in columns[0]]
    return markdown_table(["", *SOILS], table, words=1)


def _soil(name: str) -> dict[str, str]:
    soil = tomllib.loads((scenes_folder() / "soils" / f"{name}.toml").read_text(encoding="utf-8"))
    evidence, published = soil["evidence"], soil["published"]
    loosest, densest = (_angle(evidence, density) for density in (0.0, 1.0))
    found = f"{evidence['found_friction_angle']:.1f} +- {evidence['standard_error']:.1f}"
    plate = evidence["plate"]["width"]
    return {
        "bulk density of beds at rest (aimed at) [kg/m3]": (
            f"{evidence['bulk_density_measured']:.1f} ({soil['bulk_density']:g})"
        ),
        "relative density aimed at": f"{evidence['relative_density']:.3f}",
        "friction between grains (given)": f"{soil['contact']['friction']:g}",
        "rolling friction (found)": f"{soil['contact']['rolling_friction']:g}",
        "peak friction angle, biaxial, four beds (aimed at) [deg]": (
            f"{found} ({evidence['published_friction_angle']:.1f})"
        ),
        "the same, loosest beds; not fitted (published) [deg]": (
            f"{loosest} ({published['loosest_friction_angle']:g})"
        ),
        "the same, densest beds; not fitted (published) [deg]": (
            f"{densest} ({published['densest_friction_angle']:g})"
        ),
        f"plate of {1000 * plate:g} mm: exponent n of Bekker's law": f"{evidence['bekker_exponent']:.2f}",
    }


def _angle(evidence: dict[str, Any], relative_density: float) -> str:
    (tried,) = having(evidence["biaxial"], relative_density=relative_density)
    return f"{tried['friction_angle']:.1f} +- {tried['standard_error']:.1f}"


def verification() -> str:
    """How many comparisons keep their limits, and the row of each case that is nearest to its own."""
    every = document("verify-dem.json")["rows"]
    kept = sum(row["passed"] for row in every)
    verdict = "all within their limits" if kept == len(every) else f"{kept} of them within their limits"
    cases = [case for (case,) in distinct(every, "case")]
    head = ["case", "checks", "nearest to its limit", "reference", "measured", "error", "limit"]
    table = []
    for case in cases:
        own = having(every, case=case, low=None)
        if own:
            table.append([f"`{case}`", str(len(own)), *_compared(max(own, key=_used))])
    return f"**{len(every)} comparisons in {len(cases)} cases, {verdict}.**\n\n" + markdown_table(
        [*head, "where the reference comes from"], table
    )


def _used(row: Row) -> float:
    """Share of its limit that the error takes."""
    return row["relative_error"] / row["limit"] if row["limit"] else row["relative_error"]


def _compared(row: Row) -> list[str]:
    numbers = [f"{row[name]:.5g}" for name in ("reference", "measured")]
    shares = [f"{100 * row[name]:.2g} %" for name in ("relative_error", "limit")]
    return [row["quantity"], *numbers, *shares, row["source"]]


def verification_ranges() -> str:
    """Comparisons with bounds in place of a value."""
    table = [
        [
            f"`{row['case']}`",
            row["quantity"],
            f"{row['low']:.4g} to {row['high']:.4g}",
            f"{row['measured']:.3g}",
            row["source"],
        ]
        for row in document("verify-dem.json")["rows"]
        if row["low"] is not None
    ]
    return markdown_table(["case", "quantity", "range", "measured", "where the range comes from"], table)


TABLES = {
    "soils": soils,
    "verification": verification,
    "verification-ranges": verification_ranges,
}
