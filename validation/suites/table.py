"""All measurements of a suite as one tidy table: a line for each picture pair, stratum and method."""

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

LABELS = (
    "scene",
    "label",
    "soil",
    "seed",
    "picture_seed",
    "severity",
    "stride",
    "quick",
    "scene_hash",
    "method",
)
"""What a line is about; attributes of a measurement."""
ERRORS = ("pixel_count", "coverage", "median", "mean", "p95", "rmse", "bias_u", "bias_v")
WRONG = {0.3: "wrong_0.3", 0.56: "wrong_0.56", 1.0: "wrong_1.0"}
COLUMNS = (*LABELS, "pair", "stratum", *ERRORS, *WRONG.values(), "seconds")
UNITS = {
    "median": "px",
    "mean": "px",
    "p95": "px",
    "rmse": "px",
    "bias_u": "px",
    "bias_v": "px",
    "seconds": "s",
}
_TEXTS = ("scene", "label", "soil", "severity", "scene_hash", "method", "stratum")
_WHOLE = ("seed", "picture_seed", "stride", "quick", "pair")
_LONGEST_SHOWN = 60

Line = dict[str, Any]


def lines_of(measured: "xr.Dataset") -> list[Line]:
    """Lines of one measurement: a line for each of its pairs and strata."""
    labels = {name: _plain(measured.attrs[name]) for name in LABELS}
    errors = {name: measured[name].values for name in ERRORS}
    wrong = measured["wrong_share"]
    errors |= {name: wrong.sel(bound=bound).values for bound, name in WRONG.items()}
    seconds = measured["seconds"].values
    return [
        labels
        | {"pair": pair, "stratum": str(stratum)}
        | {name: float(values[pair, k]) for name, values in errors.items()}
        | {"seconds": float(seconds[pair])}
        for pair in range(measured.sizes["pair"])
        for k, stratum in enumerate(measured["stratum"].values)
    ]


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


def write_csv(lines: Sequence[Line], path: Path) -> None:
    """One line each; units in the header, nothing where there is no number."""
    with path.open("w", newline="", encoding="utf-8") as file:
        write_lines(lines, file)


def write_lines(lines: Sequence[Line], file: TextIO) -> None:
    """Write lines as CSV to an open file."""
    writer = csv.writer(file)
    writer.writerow([f"{name} [{UNITS[name]}]" if name in UNITS else name for name in COLUMNS])
    writer.writerows([_spelt(line[name]) for name in COLUMNS] for line in lines)


def read_lines(file: TextIO) -> list[Line]:
    """Read lines that `write_lines` wrote.

    Raises
    ------
    ValueError
        With line and column, and what is wrong there.
    """
    rows = csv.reader(file)
    try:
        names = [name.partition(" [")[0] for name in next(rows, [])]
        if missing := [name for name in COLUMNS if name not in names]:
            raise ValueError(f"no column {missing[0]!r}")
        return [_line(names, row, rows.line_num) for row in rows]
    except csv.Error as error:
        raise ValueError(f"line {rows.line_num}: {error}") from None


def _line(names: list[str], row: list[str], number: int) -> Line:
    if len(row) != len(names):
        raise ValueError(f"line {number}: {len(row)} values, needed are {len(names)}")
    return {name: _read(name, text, number) for name, text in zip(names, row, strict=True)}


def _read(name: str, text: str, number: int) -> Any:
    if name in _TEXTS:
        return text
    try:
        if name in _WHOLE:
            return int(text)
        return float(text) if text else np.nan
    except ValueError:
        raise ValueError(f"line {number}: {name} = {text[:_LONGEST_SHOWN]!r}: a number is needed") from None


def _spelt(value: Any) -> str:
    if isinstance(value, float):
        return "" if np.isnan(value) else f"{value:.6g}"
    return str(value)


def write_netcdf(lines: Sequence[Line], path: Path) -> None:
    """Write the same table over the dimension `line`, for xarray and pandas."""
    import xarray as xr

    variables = {
        name: ("line", np.array([line[name] for line in lines]), {"units": UNITS.get(name, "1")})
        for name in COLUMNS
    }
    xr.Dataset(variables).to_netcdf(path, engine="h5netcdf")
