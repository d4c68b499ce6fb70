"""A study's figure from its kept table: python docs/make/from_table.py STUDY TABLE.csv FIGURE.png."""

import csv
import re
import sys
from pathlib import Path

from validation.figures import to_png
from validation.studies import find_study
from validation.studies.study import Findings, Row


def read_rows(path: Path) -> list[Row]:
    """A study's table as it was written: units left off the names, numbers as numbers."""
    with path.open(newline="", encoding="utf-8") as file:
        names, *lines = csv.reader(file)
    names = [re.sub(r" \[.*\]$", "", name) for name in names]
    return [dict(zip(names, map(_value, line), strict=True)) for line in lines]


def _value(spelt: str) -> float | str:
    try:
        return float(spelt)
    except ValueError:
        return spelt


if __name__ == "__main__":
    name, table, figure = sys.argv[1:]
    drawn = find_study(name).draw(Findings(read_rows(Path(table)), conclusion=""))
    Path(figure).write_bytes(to_png(drawn))
