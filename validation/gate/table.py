"""A verdict as a table on a terminal."""

from typing import TYPE_CHECKING

from validation.gate.verdict import EVERYWHERE

if TYPE_CHECKING:
    from rich.table import Table

    from validation.gate.verdict import Row

_NAMES = {"median": "median px", "p95": "95 % px", "wrong_share": "> 0.3 px"}
_MOST_TOLD = 3
"""Of what got worse, in the last line; the table has all of it."""
_UNITS = {"median": "%", "p95": "%", "wrong_share": "pts"}


def gate_table(rows: "list[Row]") -> "Table":
    """One line for each stratum and quantity."""
    from rich.table import Table

    table = Table()
    for column, justify in (("stratum", "left"), ("error", "left"), ("baseline", "right"), ("now", "right")):
        table.add_column(column, justify=justify)  # type: ignore[arg-type]
    for column in ("change, mean of clips", "at least"):
        table.add_column(column, justify="right")
    table.add_column("most, on a clip", justify="left", no_wrap=True)
    table.add_column("worse", justify="left")
    for row in rows:
        worst = f"{change_text(row, row.worst_change)} {row.worst_clip}" if row.worst_change else ""
        cells = [_value(row, row.before), _value(row, row.after)]
        changes = [change_text(row, row.change), change_text(row, row.low), worst]
        where = "" if not row.worse else ("over all clips" if row.reason == EVERYWHERE else "on that clip")
        table.add_row(row.stratum, _NAMES[row.quantity], *cells, *changes, where)
    return table


def verdict_line(rows: "list[Row]") -> str:
    """Say in one line whether the gate is passed, or what got worse by how much."""
    worse = [row for row in rows if row.worse]
    if not worse:
        return "passed: nothing got worse by more than its interval allows"
    told = [
        f"{_NAMES[row.quantity]} in {row.stratum} {row.reason} by "
        + change_text(row, row.change if row.reason == EVERYWHERE else row.worst_change)
        for row in worse[:_MOST_TOLD]
    ]
    more = len(worse) - len(told)
    return f"failed: worse is {'; '.join(told)}" + (f"; and {more} more" if more else "")


def change_text(row: "Row", change: float | None) -> str:
    """Word a change: per cent of an error, points of a share."""
    if change is None:
        return "-"
    return f"{100 * change:+.1f} {_UNITS[row.quantity]}"


def _value(row: "Row", value: float | None) -> str:
    if value is None:
        return "-"
    return f"{value:.1%}" if row.quantity == "wrong_share" else f"{value:.4f}"
