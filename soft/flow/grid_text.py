"""Grids of vectors as text: `.csv` and `.txt` with a header that names the columns.

Read are x, y, u, v in px and, if there, what tells measured vectors from others: `flags` and `mask` (OpenPIV:
0 = measured), `vector type` (PIVlab: 1 = measured, 0 = masked, 2 = interpolated). Other columns, and lines
before the header, are passed over.
"""

import re
from pathlib import Path

import numpy as np

from soft.flow.field import FlowError
from soft.flow.grid import Grid

_NEEDED = ("x", "y", "u", "v")
_ZERO_IF_MEASURED = ("flag", "flags", "mask")
_ONE_IF_MEASURED = ("vector type", "typevector", "type")
_PIXEL_UNITS = ("", "px", "pixel", "pixels", "px/frame", "pixel/frame", "pixels/frame", "px/fr")


def read_text_grid(path: Path) -> Grid:
    """Vectors of one picture pair.

    Raises
    ------
    FlowError
        If the file cannot be read, has no such header, other units, or a line that does not fit.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise FlowError(f"{path}: cannot be read as text: {error}") from error
    start, names, separator = _header(path, lines)
    rows = _rows(path, lines[start:], start, len(names), separator)
    table = np.array(rows, dtype=float).reshape(-1, len(names))
    column = {name: table[:, k] for k, name in enumerate(names)}
    measured = np.ones(len(table), bool)
    for name in names:
        if name in _ZERO_IF_MEASURED:
            measured &= column[name] == 0
        elif name in _ONE_IF_MEASURED:
            measured &= column[name] == 1
    x, y, u, v = (column[name] for name in _NEEDED)
    return Grid(x, y, u, v, measured)


def _header(path: Path, lines: list[str]) -> tuple[int, list[str], str | None]:
    """Number of the line after the header, names of columns, and what separates them (None: blanks)."""
    for number, line in enumerate(lines):
        # A unit belongs to the name before it, blanks between them or not.
        line = re.sub(r"\s+(?=[\[(])", "", line.lstrip("#% "))
        for separator in (",", ";", "\t", None):
            cells = line.split(separator)
            told = [_name_and_unit(cell) for cell in cells]
            names = [name for name, _ in told]
            if set(_NEEDED) <= set(names):
                _require_pixels(path, dict(told))
                return number + 1, names, separator
    raise FlowError(f"{path}: no header that names the columns x, y, u, v")


def _name_and_unit(cell: str) -> tuple[str, str]:
    """Split `u [px/frame]` or `u (px)`; lower case."""
    name, unit = re.fullmatch(r"([^\[(]*)(?:[\[(](.*)[\])])?.*", cell.strip().strip('"').lower()).groups()  # type: ignore[union-attr]
    return name.strip(), (unit or "").strip()


def _require_pixels(path: Path, units: dict[str, str]) -> None:
    for name in _NEEDED:
        if units[name] not in _PIXEL_UNITS:
            raise FlowError(f"{path}: {name} in {units[name]}: must be px (export before calibration)")


def _rows(path: Path, lines: list[str], before: int, width: int, separator: str | None) -> list[list[float]]:
    rows = []
    for number, line in enumerate(lines, start=before + 1):
        if not line.strip() or line.lstrip().startswith(("#", "%")):
            continue
        cells = line.split(separator)
        try:
            row = [float(cell.strip() or "nan") for cell in cells]
        except ValueError:
            raise FlowError(f"{path}: line {number}: {line.strip()[:60]!r}: must be numbers") from None
        if len(row) != width:
            raise FlowError(f"{path}: line {number}: {len(row)} columns: the header names {width}")
        rows.append(row)
    return rows
