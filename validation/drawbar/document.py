"""Curves told: the JSON document, the table, lines for a person; the published maxima beside."""

import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from validation.drawbar.curve import REDUCTIONS, Curve
from validation.published import read_published

if TYPE_CHECKING:
    from rich.table import Table

PUBLISHED = "paper_drawbar"
SCARAB = "scarab"
"""The vehicle that was published."""


@dataclass(frozen=True)
class Ratio:
    """What inching gains over rolling.

    Attributes
    ----------
    wheel, law : str
    value : float
        Maximum by inching / maximum by rolling.
    at_travel_reduction : dict
        The same of the pulls at travel reductions; None where either gait did not get there.
    published : float
        Of the maxima.
    """

    wheel: str
    law: str
    value: float
    at_travel_reduction: dict[str, float | None]
    published: float


def published_maximum(curve: Curve) -> float | None:
    """Published maximum of drawbar pull over weight; None for another vehicle."""
    if curve.order.vehicle != SCARAB:
        return None
    return read_published(PUBLISHED)[curve.order.published_name].value


def ratios(curves: Sequence[Curve]) -> list[Ratio]:
    """One for each wheel and law that was measured in both gaits."""
    known = {(one.order.gait, one.order.wheel, one.order.law): one for one in curves}
    found = []
    for (gait, wheel, law), inching in known.items():
        if gait == "inching" and ("rolling", wheel, law) in known:
            found.append(_ratio(inching, known["rolling", wheel, law]))
    return found


def _ratio(inching: Curve, rolling: Curve) -> Ratio:
    published = read_published(PUBLISHED)
    wheel, above, below = inching.order.wheel, inching.at_travel_reduction, rolling.at_travel_reduction
    at = {name: pull / under if pull and (under := below[name]) else None for name, pull in above.items()}
    known = published[f"inching_{wheel}"].value / published[f"rolling_{wheel}"].value
    return Ratio(wheel, inching.order.law, inching.maximum / rolling.maximum, at, known)


def drawbar_document(curves: Sequence[Curve]) -> dict[str, Any]:
    """The JSON document: curves, and besides the published maxima and the ratios of the gaits."""
    return {
        "schema_version": 1,
        "vehicle_weight": curves[0].vehicle_weight,
        "curves": [_curve_document(curve) for curve in curves],
        "ratios": [vars(ratio) for ratio in ratios(curves)] if curves[0].order.vehicle == SCARAB else [],
    }


def _curve_document(curve: Curve) -> dict[str, Any]:
    order = curve.order
    return {
        "gait": order.gait,
        "wheel": order.wheel,
        "law": order.law,
        "points": [
            {"drawbar_pull_ratio": point.drawbar_pull_ratio, "travel_reduction": point.travel_reduction}
            for point in curve.points
        ],
        "maximum": curve.maximum,
        "maximum_reached": curve.reached,
        "published_maximum": published_maximum(curve),
        "at_travel_reduction": curve.at_travel_reduction,
    }


def write_table(curves: Sequence[Curve], path: Path) -> None:
    """Write the points and who pushed: one line for each curve, load, phase and wheel."""
    rows = [row for curve in curves for row in _rows(curve)]
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)


def _rows(curve: Curve) -> Iterator[dict[str, Any]]:
    order = curve.order
    for point in curve.points:
        for phase in point.phases:
            for wheel in phase.wheels:
                yield {
                    "gait": order.gait,
                    "wheel_kind": order.wheel,
                    "law": order.law,
                    "drawbar_pull_ratio": point.drawbar_pull_ratio,
                    "travel_reduction": point.travel_reduction,
                    "velocity_m_s": point.velocity,
                    "phase": phase.phase,
                    "duration_s": phase.duration,
                    "wheel": wheel.wheel,
                    "force_x_N": wheel.force_x,
                    "force_z_N": wheel.force_z,
                    "torque_Nm": wheel.torque,
                    "advance_m": wheel.advance,
                    "rolled_m": wheel.rolled,
                    "sinkage_m": wheel.sinkage,
                }


def drawbar_table(curves: Sequence[Curve]) -> "Table":
    """A table for the terminal."""
    from rich.table import Table

    table = Table(title="Drawbar pull / vehicle weight")
    columns = (
        "gait",
        "wheel",
        "law",
        *(f"at {reduction:.0%}" for reduction in REDUCTIONS),
        "maximum",
        "published",
    )
    for name in (*columns, "difference"):
        table.add_column(name, justify="left" if name in ("gait", "wheel", "law") else "right")
    for curve in curves:
        order, published = curve.order, published_maximum(curve)
        at = [_number(value) for value in curve.at_travel_reduction.values()]
        maximum = ("" if curve.reached else "> ") + _number(curve.maximum)
        difference = "" if published is None or not curve.reached else f"{curve.maximum / published - 1:+.0%}"
        table.add_row(order.gait, order.wheel, order.law, *at, maximum, _number(published), difference)
    return table


def ratio_lines(curves: Sequence[Curve]) -> str:
    """What inching gains, beside what was published."""
    return "\n".join(
        f"inching / rolling, {one.wheel} wheels, {one.law}: maxima {one.value:.2f} "
        f"(published {one.published:.2f}); {_at_reductions(one)}"
        for one in ratios(curves)
    )


def _at_reductions(ratio: Ratio) -> str:
    return ", ".join(
        f"at {float(name):.0%} travel reduction {value:.2f}"
        for name, value in ratio.at_travel_reduction.items()
        if value is not None
    )


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"
