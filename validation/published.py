"""Published numbers to stand beside ours; one CSV file a table, its source in the header."""

import csv
from dataclasses import dataclass
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
        In `unit`.
    unit : str
        `1` for a pure number.
    where : str
        Place in the source.
    """

    quantity: str
    value: float
    unit: str
    where: str


def read_published(table: str) -> dict[str, Published]:
    """Read `reference/<table>.csv`: its rows by quantity."""
    text = (REFERENCE_FOLDER / f"{table}.csv").read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    rows = csv.DictReader(lines)
    return {
        row["quantity"]: Published(row["quantity"], float(row["value"]), row["unit"], row["where"])
        for row in rows
    }
