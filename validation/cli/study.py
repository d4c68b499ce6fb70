"""The command that runs a scene several times."""

from pathlib import Path
from typing import Annotated, Any

import typer

from validation.cli.app import app
from validation.cli.options import Debug, Device, Json, Overwrite, Quick, Resume, Seed, Threads
from validation.studies import STUDIES, find_study
from validation.terminal import Terminal


@app.command()
def study(
    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME", help="; ".join(f"[b]{name}[/b]: {about}" for name, about in STUDIES.items())
        ),
    ],
    out: Annotated[Path, typer.Argument(metavar="OUT", help="The study's folder; every run is in OUT/runs.")],
    scene: Annotated[
        str | None,
        typer.Option("--scene", metavar="SCENE", help="Start from this scene.", show_default=False),
    ] = None,
    quick: Quick = False,
    seed: Seed = None,
    resume: Resume = True,
    overwrite: Overwrite = False,
    threads: Threads = None,
    device: Device = "cpu",
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Run a scene several times with something changed: OUT/NAME.csv, NAME.png and a line of conclusion.

    Carried out again, it does only what is missing.
    """
    from synth import load_scene
    from validation import chain
    from validation.studies.carry_out import carry_out

    terminal = Terminal(json=json)
    with terminal.working():
        chosen = load_scene(scene or find_study(name).scene, quick=quick, seed=seed)
        work = chain.Work(device, threads)
        document = carry_out(
            name,
            find_study(name),
            chosen,
            out,
            quick=quick,
            resume=resume,
            overwrite=overwrite,
            work=work,
            terminal=terminal,
        )
    show_study(document, out, terminal)
    terminal.give(document)


def show_study(document: dict[str, Any], out: Path, terminal: Terminal) -> None:
    """Show a study's table, conclusion and files."""
    from validation.studies.carry_out import study_table

    terminal.show(study_table(document))
    terminal.show(document["conclusion"])
    terminal.show(f"{out / document['study']}.csv, .png, .json")
