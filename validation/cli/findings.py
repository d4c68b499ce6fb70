"""The command that tells what a suite found, from its kept tables: findings."""

from pathlib import Path
from typing import Annotated

import typer

from validation.cli.app import app
from validation.cli.options import Debug, Json
from validation.terminal import Terminal


@app.command()
def findings(
    out: Annotated[Path, typer.Argument(metavar="DIR", help="Where figures go.")],
    tables: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="A suite's tables, OUT/complex-tables.  [default: those that come along]",
            show_default=False,
        ),
    ] = None,
    update: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FILE",
            help="A Markdown file whose tables between `<!-- findings: NAME -->` and `<!-- end -->` are "
            "brought up to date; may repeat.",
            show_default=False,
        ),
    ] = None,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Leaderboard and errors in complex flow, from the kept tables of the suite `complex`: DIR/*.png."""
    from validation.suites.findings import leaderboard, update_document
    from validation.suites.findings_figures import write_figures
    from validation.suites.kept import SHIPPED, read_kept

    terminal = Terminal(json=json)
    with terminal.working():
        kept = read_kept(tables or SHIPPED)
        written = write_figures(kept, out)
        for path in update or []:
            update_document(path, kept)
    terminal.show(leaderboard(kept))
    files = {"figures": written, "updated": update or []}
    terminal.show(", ".join(str(path) for paths in files.values() for path in paths))
    told = {"schema_version": 1, "measured": kept.about["measured"], "of": kept.about["of"]}
    terminal.give(told | {name: [str(path) for path in paths] for name, paths in files.items()})
