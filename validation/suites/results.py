"""What a suite leaves behind: a tidy table (CSV and netCDF), its headlines (JSON), a page (HTML)."""

import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from synth.disk import written_whole
from validation.statistics import Interval
from validation.suites.execution import Failure
from validation.suites.gathered import gather
from validation.suites.headline import GROUP, comparisons, group_title, headline_document, headlines
from validation.suites.kept import write_kept
from validation.suites.plan import Suite
from validation.suites.report import write_suite_report
from validation.suites.table import write_csv, write_netcdf
from validation.versions import machine, package_versions

if TYPE_CHECKING:
    from rich.table import Table

SCHEMA_VERSION = 1


def write_results(suite: Suite, out: Path, failures: Sequence[Failure], *, command: str) -> dict[str, Any]:
    """Write OUT/NAME.csv, .nc, .json and .html from the measurements that are there; return the JSON.

    OUT/NAME-tables are the same, small enough to be kept (see `validation.suites.kept`). `command` is what a
    person types to get all of it again.
    """
    gathered = gather(suite, out)
    lines = gathered.lines
    compared = comparisons(lines)
    document = {
        "schema_version": SCHEMA_VERSION,
        "suite": suite.name,
        "about": suite.about,
        "methods": [*suite.methods, *suite.slow_methods],
        "measured": len(gathered.looks),
        "of": len(suite.looks),
        "failures": [asdict(failure) for failure in failures],
        "versions": package_versions(),
        "machine": machine(),
        **headline_document(headlines(lines), compared),
    }
    own_page = suite.write_own_page(out, failures, command=command)
    document |= own_page or {}
    with written_whole(out / f"{suite.name}.csv") as draft:
        write_csv(lines, draft)
    if lines:
        with written_whole(out / f"{suite.name}.nc") as draft:
            write_netcdf(lines, draft)
    with written_whole(out / f"{suite.name}.json") as draft:
        draft.write_text(json.dumps(document, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    if lines and not failures:
        suite.write_more(lines, out)
    if lines and own_page is None:
        with written_whole(out / f"{suite.name}.html") as draft:
            write_suite_report(
                draft,
                suite=suite,
                gathered=gathered,
                comparisons=compared,
                failures=failures,
                command=command,
            )
        about = {name: document[name] for name in ("suite", "measured", "of", "versions", "machine")}
        write_kept(gathered, out / f"{suite.name}-tables", {"command": command, **about})
    return document


def results_table(document: dict[str, Any], strata: Iterable[str] = ("all", "moving", "complex")) -> "Table":
    """The headlines for a terminal."""
    from rich.table import Table

    table = Table(title=f"suite {document['suite']}: {document['about']}", title_justify="left")
    for column in ("scene", "stratum", "method"):
        table.add_column(column, overflow="fold")
    for column in ("median px", "95 % px", "> 0.3 px", "of"):
        table.add_column(column, justify="right", no_wrap=True)
    former = ("", "")
    for one in document["headlines"]:
        if one["stratum"] in strata:
            here = group_title(*(one[name] for name in GROUP)), one["method"]
            shown = ("", "") if here == former else here
            table.add_row(shown[0], one["stratum"], shown[1], *_cells(one))
            former = here
    return table


def _cells(headline: dict[str, Any]) -> list[str]:
    errors = headline["errors"]
    shown = [_with_interval(errors.get(name), form) for name, form in _FORMS.items()]
    return [*shown, str(errors["wrong_0.3"]["realisation_count"])]


_FORMS = {"median": ".3f", "p95": ".3f", "wrong_0.3": ".1%"}


def _with_interval(interval: dict[str, Any] | None, form: str) -> str:
    if interval is None:
        return "-"
    known: dict[str, Any] = {name: np.nan if value is None else value for name, value in interval.items()}
    return Interval(**known).told(form)
