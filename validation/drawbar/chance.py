"""How far chance moves a curve: the same curve measured again and again, its history a little another."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from validation.drawbar.curve import HIGH_REDUCTION, REDUCTIONS, Curve, CurveOrder

if TYPE_CHECKING:
    from rich.table import Table


@dataclass(frozen=True)
class Chance:
    """Of a drawbar pull over weight, over repeats.

    Attributes
    ----------
    order : CurveOrder
        The first of the repeats.
    reduction : float
        Travel reduction that the pull is at.
    pulls : tuple of float
        Of those repeats that got there.
    """

    order: CurveOrder
    reduction: float
    pulls: tuple[float, ...]

    @property
    def mean(self) -> float:
        """Of the repeats."""
        return float(np.mean(self.pulls))

    @property
    def deviation(self) -> float:
        """Standard deviation of one repeat; NaN of fewer than two."""
        return float(np.std(self.pulls, ddof=1)) if len(self.pulls) > 1 else float("nan")


def chances(curves: Sequence[Curve]) -> list[Chance]:
    """For each curve that was repeated, the pulls at travel reductions and at that of the maximum."""
    known: dict[CurveOrder, list[Curve]] = {}
    for curve in curves:
        known.setdefault(replace(curve.order, repeat=0), []).append(curve)
    found = []
    for order, repeats in known.items():
        for reduction in (*REDUCTIONS, HIGH_REDUCTION):
            pulls = tuple(pull for one in repeats if (pull := one.pull_at(reduction)) is not None)
            if pulls:
                found.append(Chance(order, reduction, pulls))
    return found


def write_chance(curves: Sequence[Curve], path: Path) -> Path:
    """Write one line for each curve and travel reduction."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(
            ["gait", "wheel", "law", "travel_reduction", "repeats", "mean", "deviation", "least", "greatest"]
        )
        for one in chances(curves):
            writer.writerow(
                [one.order.gait, one.order.wheel, one.order.law, one.reduction, len(one.pulls)]
                + [f"{value:.4f}" for value in (one.mean, one.deviation, min(one.pulls), max(one.pulls))]
            )
    return path


def chance_table(curves: Sequence[Curve]) -> "Table":
    """`chances` for the terminal: mean and standard deviation, and the range."""
    from rich.table import Table

    table = Table(title="Drawbar pull / vehicle weight over repeats")
    for name in ("gait", "wheel", "law", "travel reduction", "repeats", "mean", "deviation", "range"):
        table.add_column(name, justify="left" if name in ("gait", "wheel", "law") else "right")
    for one in chances(curves):
        table.add_row(
            one.order.gait,
            one.order.wheel,
            one.order.law,
            f"{one.reduction:.0%}",
            str(len(one.pulls)),
            f"{one.mean:.3f}",
            f"{one.deviation:.3f}",
            f"{min(one.pulls):.3f} to {max(one.pulls):.3f}",
        )
    return table
