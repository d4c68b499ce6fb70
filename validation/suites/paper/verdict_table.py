"""Verdicts that were kept, as the Markdown table of the docs."""

import csv
from pathlib import Path

import numpy as np

from validation.markdown_tables import markdown_table
from validation.published import REFERENCE_FOLDER, Published
from validation.statistics import Interval
from validation.suites.paper.conclusion import Conclusion
from validation.suites.paper.verdict import (
    DIFFERS,
    JUDGED,
    Row,
    Variant,
    number,
    our_words,
    published_words,
)

KEPT = {
    name: REFERENCE_FOLDER / "measured" / f"{name}.csv" for name in ("paper-verdicts", "paper-quick-verdicts")
}
"""Files that come along, by the name of their table in the docs."""
_BESIDE = Variant("robust-affine", JUDGED.severity)


def verdict_table(path: Path) -> str:
    """How many of the published numbers are reproduced, and each of them beside ours."""
    conclusion = Conclusion(read_verdicts(path))
    ours, beside = (f"`{one.method}`, severity {one.severity}" for one in (JUDGED, _BESIDE))
    head = ["experiment", "published", "", ours, "in truth", beside, "verdict"]
    table = markdown_table(head, (_cells(conclusion, row) for row in conclusion.judged))
    return f"**{conclusion.sentence}.**\n\n{table}"


def read_verdicts(path: Path) -> tuple[Row, ...]:
    """Read what `validation.suites.paper.conclusion.write_verdicts` wrote."""
    with path.open(newline="", encoding="utf-8") as file:
        return tuple(_row(line) for line in csv.DictReader(file))


def _row(line: dict[str, str]) -> Row:
    value, low, high, truth, least, published, most = (
        float(line[name] or "nan")
        for name in ("value", "low", "high", "truth", "published_low", "published", "published_high")
    )
    counts = int(line["realisations"]), int(line["pairs"])
    return Row(
        experiment=line["experiment"],
        published=Published(
            line["quantity"], published, line["unit"], line["where"], least, most, line["says"]
        ),
        case=line["case"],
        variant=Variant(line["method"], line["severity"]),
        ours=None if np.isnan(value) else Interval(value, low, high, *counts),
        truth=truth,
        verdict=line["verdict"],
        reason=line["reason"],
    )


def _cells(conclusion: Conclusion, row: Row) -> list[str]:
    beside = next((one.ours for one in conclusion.beside(row) if one.variant == _BESIDE), None)
    says = row.published.says.partition(': "')[0] + (f" ({row.case})" if row.case else "")
    unit = "" if row.published.unit == "1" else f" {row.published.unit}"
    truth = "" if np.isnan(row.truth) else number(row.truth)
    verdict = f"**{row.verdict}**" if row.verdict == DIFFERS else row.verdict
    published = published_words(row.published) + unit
    return [row.experiment, says, published, our_words(row.ours), truth, our_words(beside), verdict]
