"""The command that makes data sets: sweep."""

from pathlib import Path
from typing import Annotated, Any

import typer

from validation.cli.app import CHECK_FAILED, app
from validation.cli.options import Debug, Device, Json
from validation.terminal import Terminal


@app.command()
def sweep(
    file: Annotated[Path, typer.Argument(metavar="SWEEP", help="A TOML file: a scene, and what is varied.")],
    out: Annotated[Path, typer.Argument(metavar="OUT", help="The data set's folder.")],
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Only say how many, how long and how large.")
    ] = False,
    scheduler: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS", help="A dask scheduler of your own, tcp://host:8786.", show_default=False
        ),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(min=1, metavar="N", help="Processes here, a core each.", show_default="one a core"),
    ] = None,
    device: Device = "cpu",
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Make a data set: a scene again and again with other values, with pictures and truth: OUT/data_card.md.

    Stopped and called again, it does only what is missing. Exit status 1 where something failed; the rest is
    done nevertheless.
    """
    if scheduler is not None and workers is not None:
        raise typer.BadParameter("--workers: a scheduler of your own has its own")
    terminal = Terminal(json=json)
    if dry_run:
        _foretell(file, out, workers, terminal)
        return
    from synth.dataset.execution import make_data_set

    with terminal.working(), terminal.progress("sweep") as progress:
        manifest = make_data_set(
            file,
            out,
            scheduler=scheduler,
            workers=workers,
            device=device,
            say=terminal.say,
            progress=progress,
        )
    terminal.show(_told(manifest, out))
    terminal.give({**manifest, "folder": str(out)})
    if not manifest["complete"]:
        raise typer.Exit(CHECK_FAILED)


def _foretell(file: Path, out: Path, workers: int | None, terminal: Terminal) -> None:
    from synth.dataset.forecast import forecast
    from validation.cli.sweep_table import forecast_table

    with terminal.working():
        found = forecast(file, out, workers=workers)
    terminal.show(forecast_table(found))
    terminal.give(found.to_dict())


def _told(manifest: dict[str, Any], out: Path) -> str:
    splits = ", ".join(f"{count} {split}" for split, count in manifest["split_counts"].items())
    lines = [
        f"{manifest['made_count']} of {manifest['member_count']} sequences ({splits}): {out}/data_card.md"
    ]
    if manifest["failed_count"]:
        lines.append(f"{manifest['failed_count']} failed: {out}/failures.csv")
    return "\n".join([*lines, f"hash of the values: {manifest['digest']}"])
