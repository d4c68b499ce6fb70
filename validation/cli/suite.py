"""The command that measures many pictures with many methods: suite."""

from pathlib import Path
from typing import Annotated, Any

import typer

from validation.cli.app import CHECK_FAILED, app
from validation.cli.folders import methods_of_this_folder
from validation.cli.options import Debug, Json, Methods, Quick
from validation.terminal import Terminal


@app.command()
def suite(
    name: Annotated[
        str,
        typer.Argument(metavar="NAME", help="smoke, paper, complex, or anchor (finds the severity `paper`)."),
    ],
    out: Annotated[Path, typer.Argument(metavar="OUT", help="A folder; several suites may share it.")],
    method: Methods = None,
    quick: Quick = False,
    processes: Annotated[int | None, typer.Option(min=1, show_default="one a core")] = None,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Measure scenes x seeds x pictures with every method: OUT/NAME.html, .csv, .nc, .json.

    Further methods join by --method. Stopped and called again, it does only what is missing. Exit status 1
    where something failed; the rest is done nevertheless.
    """
    from validation.chain import require_methods
    from validation.methods import choose
    from validation.suites.catalogue import find_suite
    from validation.suites.execution import carry_out
    from validation.suites.results import write_results

    terminal = Terminal(json=json)
    with terminal.working(), methods_of_this_folder():
        own = find_suite(name, quick=quick)
        require_methods(choose(method or []))
        # Those of the suite too: two methods must not be filed under one name.
        chosen = own.with_methods([one.name for one in choose([*own.methods, *(method or [])])])
        failures = carry_out(chosen, out, processes=processes, terminal=terminal)
        asked = " ".join(
            [name, "OUT", *(["--quick"] if quick else []), *(f"--method {m}" for m in method or [])]
        )
        document = write_results(chosen, out, failures, command=f"softbed suite {asked}")
    _show(document, out, terminal)
    terminal.give(document)
    if failures:
        raise typer.Exit(CHECK_FAILED)


def _show(document: dict[str, Any], out: Path, terminal: Terminal) -> None:
    from validation.suites.results import results_table

    if "verdicts" in document:
        from validation.suites.paper.conclusion import verdict_lines

        terminal.show(verdict_lines(document))
    else:
        terminal.show(results_table(document))
    for failure in document["failures"]:
        terminal.show(f"failed: {failure['name']}: {failure['reason']}")
    terminal.show(f"{out / document['suite']}.html, .csv, .nc, .json")
