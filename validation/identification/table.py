"""An identification for a terminal."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.table import Table

_MILLIMETRES = ("sinkage", "sinkage_error", "sinkage_law", "sinkage_unfitted_law")


def constants_line(estimates: Mapping[str, Any]) -> str:
    """Each constant with its confidence interval."""
    return "; ".join(
        f"{name} {one['value']:.3g} (95 %: {one['low']:.3g} to {one['high']:.3g})"
        for name, one in estimates.items()
    )


def rows_table(title: str, rows: Sequence[Mapping[str, Any]]) -> "Table":
    """Rows as a table; sinkage in mm, forces in N, torque in N m."""
    from rich.table import Table

    table = Table(title=title, title_justify="left")
    for name in rows[0]:
        text = isinstance(rows[0][name], str)
        unit = "\n[mm]" if name in _MILLIMETRES else ""
        table.add_column(name.replace("_", " ") + unit, justify="left" if text else "right", overflow="fold")
    for row in rows:
        table.add_row(*(_spelt(name, value) for name, value in row.items()))
    return table


def _spelt(name: str, value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, str):
        return value
    return f"{1000 * value if name in _MILLIMETRES else value:.3g}"
