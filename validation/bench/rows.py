"""What a benchmark gives: rows of one figure each, own and peers' side by side."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from validation.versions import machine

if TYPE_CHECKING:
    from rich.table import Table

SCHEMA_VERSION = 1


class PeerError(RuntimeError):
    """A peer cannot be run here; the message says why."""


@dataclass(frozen=True)
class BenchRow:
    """One figure.

    Attributes
    ----------
    case : str
        The work.
    subject : str
        Who did it.
    version : str
        Of the subject; for one that is not there, why not.
    own : bool
        Ours, or a peer's.
    metric, unit : str
    value : float or None
        None where it could not be measured.
    repeats : int
        How often it was measured; the value is their median.
    """

    case: str
    subject: str
    version: str
    own: bool
    metric: str
    value: float | None
    unit: str
    repeats: int


def bench_document(bench: str, rows: Sequence[BenchRow], *, threads: int, device: str) -> dict[str, Any]:
    """The JSON document of `softbed bench`."""
    return {
        "schema_version": SCHEMA_VERSION,
        "bench": bench,
        "machine": {"cpu": machine()["cpu"], "threads": threads, "device": device},
        "rows": [asdict(row) for row in rows],
    }


def bench_table(title: str, rows: Sequence[BenchRow]) -> "Table":
    """The same as a table for a terminal."""
    from rich.table import Table

    table = Table(title=title, title_justify="left")
    for column in ("case", "subject", "version", "metric"):
        table.add_column(column)
    for column in ("value", "unit", "repeats"):
        table.add_column(column, justify="right")
    for row in rows:
        value = "-" if row.value is None else f"{row.value:.4g}"
        table.add_row(row.case, row.subject, row.version, row.metric, value, row.unit, str(row.repeats))
    return table
