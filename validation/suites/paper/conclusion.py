"""What the suite `paper` concludes: rows of verdicts, as a table on disk and in words."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.suites.paper import averaging, bucket, drawbar, piv, rotation, sift, speed, thrust
from validation.suites.paper.experiment import Experiment
from validation.suites.paper.found import Found
from validation.suites.paper.verdict import (
    DIFFERS,
    JUDGED,
    NOT_MEASURED,
    REPRODUCED,
    Row,
    our_words,
    published_words,
)

if TYPE_CHECKING:
    from rich.table import Table

COLUMNS = (
    "experiment", "quantity", "case", "says", "where", "unit", "published", "published_low", "published_high",
    "method", "severity", "value", "low", "high", "truth", "realisations", "pairs", "judged", "verdict",
    "reason",
)  # fmt: skip


def experiments() -> tuple[Experiment, ...]:
    """All there are, in the paper's order; the rover's where a rover is there."""
    measured = (rotation, speed, sift, averaging, thrust)
    last = (*drawbar.experiments(), bucket.EXPERIMENT, piv.EXPERIMENT)
    return (*(module.EXPERIMENT for module in measured), *last)


@dataclass(frozen=True)
class Conclusion:
    """All rows of all experiments.

    Attributes
    ----------
    rows : tuple of Row
    """

    rows: tuple[Row, ...]

    @classmethod
    def of(cls, found: Found) -> "Conclusion":
        """Judge what was measured, by every variant."""
        return cls(
            tuple(
                row
                for experiment in experiments()
                for variant in found.variants
                for row in experiment.rows(found, variant)
            )
        )

    @property
    def judged(self) -> tuple[Row, ...]:
        """The rows that the verdict rests on."""
        return tuple(row for row in self.rows if row.variant == JUDGED)

    @property
    def counts(self) -> dict[str, int]:
        """Judged rows by verdict."""
        return {
            verdict: sum(row.verdict == verdict for row in self.judged)
            for verdict in (REPRODUCED, DIFFERS, NOT_MEASURED)
        }

    @property
    def sentence(self) -> str:
        """The result in words."""
        counts = self.counts
        total = sum(counts.values())
        return f"{counts[REPRODUCED]} of {total} published numbers are reproduced, {counts[DIFFERS]} differ"

    def beside(self, row: Row) -> list[Row]:
        """The same quantity by every other variant."""
        key = row.experiment, row.published.quantity, row.case
        return [
            other
            for other in self.rows
            if (other.experiment, other.published.quantity, other.case) == key and other.variant != JUDGED
        ]

    def to_dict(self) -> dict[str, Any]:
        """For the suite's JSON."""
        return {"verdict": self.sentence, "verdicts": [_in_words(row) for row in self.judged]}


def cells(row: Row) -> dict[str, Any]:
    """One line of the table."""
    ours, published = row.ours, row.published
    numbers = (np.nan,) * 3 if ours is None else (ours.value, ours.low, ours.high)
    counts = (0, 0) if ours is None else (ours.realisation_count, ours.pair_count)
    values = (
        row.experiment, published.quantity, row.case, published.says, published.where, published.unit,
        published.value, published.low, published.high, row.variant.method, row.variant.severity,
        *numbers, row.truth, *counts, int(row.variant == JUDGED), row.verdict, row.reason,
    )  # fmt: skip
    return dict(zip(COLUMNS, values, strict=True))


def _in_words(row: Row) -> dict[str, Any]:
    """A line for JSON, with what a table shows of it."""
    known = {k: None if isinstance(v, float) and not np.isfinite(v) else v for k, v in cells(row).items()}
    return known | {"published_words": published_words(row.published), "our_words": our_words(row.ours)}


def write_verdicts(rows: Sequence[Row], path: Path) -> None:
    """One line each; nothing where there is no number."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        writer.writerows([_spelt(value) for value in cells(row).values()] for row in rows)


def _spelt(value: Any) -> str:
    if isinstance(value, float):
        return "" if np.isnan(value) else f"{value:.6g}"
    return str(value)


def verdict_lines(document: dict[str, Any]) -> "Table":
    """The verdicts of a suite's JSON for a terminal."""
    from rich.table import Table

    table = Table(title=document["verdict"], title_justify="left")
    for column in ("experiment", "published", "", "ours", "verdict"):
        table.add_column(column, overflow="fold")
    former = ""
    for line in document["verdicts"]:
        says = f"{line['says']} ({line['case']})" if line["case"] else line["says"]
        name = "" if line["experiment"] == former else line["experiment"]
        table.add_row(name, says, line["published_words"], line["our_words"], line["verdict"])
        former = line["experiment"]
    return table
