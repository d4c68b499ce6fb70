"""Published numbers to stand beside ours; one CSV file a table, its source in the header."""

import csv
from dataclasses import dataclass
from math import nan
from pathlib import Path

REFERENCE_FOLDER = Path(__file__).parent / "reference"


@dataclass(frozen=True)
class Published:
    """One published number.

    Attributes
    ----------
    quantity : str
        Its name.
    value : float
        In `unit`; NaN where the source says it in words.
    low, high : float
        What the source allows for: its own bounds, those of the last digit it prints, or what its words are
        taken to mean (the file's header says which); `value` where the table has none.
    unit : str
        `1` for a pure number.
    where : str
        Place in the source.
    says : str
        What is told, in words.
    """

    quantity: str
    value: float
    unit: str
    where: str
    low: float = nan
    high: float = nan
    says: str = ""


def read_published(table: str) -> dict[str, Published]:
    """Read `reference/<table>.csv`: its rows by quantity."""
    text = (REFERENCE_FOLDER / f"{table}.csv").read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    rows = csv.DictReader(lines)
    return {row["quantity"]: _published(row) for row in rows}


def _published(row: dict[str, str]) -> Published:
    value = float(row["value"] or "nan")
    low, high = (float(row.get(name) or value) for name in ("low", "high"))
    return Published(row["quantity"], value, row["unit"], row["where"], low, high, row.get("says", ""))
