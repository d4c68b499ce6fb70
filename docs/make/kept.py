"""Files that commands wrote and that are kept, as they were written, in docs/measured: read as rows."""

import csv
import json
import re
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parents[1] / "measured"

Row = dict[str, Any]


def read_rows(path: Path) -> list[Row]:
    """A table as a study writes it: units left off the names, numbers as numbers."""
    with path.open(newline="", encoding="utf-8") as file:
        names, *lines = csv.reader(file)
    names = [re.sub(r" \[.*\]$", "", name) for name in names]
    return [dict(zip(names, map(_value, line), strict=True)) for line in lines]


def rows(name: str, **wanted: float | str) -> list[Row]:
    """Rows of a kept table, those that have the wanted values."""
    return having(read_rows(FOLDER / name), **wanted)


def document(name: str) -> dict[str, Any]:
    """A kept JSON document."""
    return json.loads((FOLDER / name).read_text(encoding="utf-8"))


def having(several: list[Row], **wanted: float | str | None) -> list[Row]:
    """Those rows that have the wanted values, in their order."""
    return [row for row in several if all(row[name] == value for name, value in wanted.items())]


def the_one(several: list[Row], **wanted: float | str | None) -> Row:
    """The only row that has the wanted values."""
    (row,) = having(several, **wanted)
    return row


def distinct(several: list[Row], *names: str) -> list[tuple[Any, ...]]:
    """What columns hold together, each once, in the order they are met."""
    return list(dict.fromkeys(tuple(row[name] for name in names) for row in several))


def _value(spelt: str) -> float | str:
    try:
        return float(spelt)
    except ValueError:
        return spelt
