"""Commands that make footage: simulate, render."""

from typing import Annotated

import typer

from validation.cli.app import app
from validation.cli.folders import step_document
from validation.cli.options import (
    Debug,
    Device,
    Json,
    OutFolder,
    Overwrite,
    Quick,
    Resume,
    RunPath,
    SceneName,
    Seed,
    Threads,
)
from validation.terminal import Terminal


@app.command()
def simulate(
    scene: SceneName,
    out: OutFolder,
    quick: Quick = False,
    seed: Seed = None,
    resume: Resume = True,
    overwrite: Overwrite = False,
    convergence: Annotated[
        bool,
        typer.Option(
            "--convergence",
            help="Also at half speed-up, doubled box, halved step, another seed: OUT/convergence.",
        ),
    ] = False,
    threads: Threads = None,
    device: Device = "cpu",
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Simulate a scene: OUT/recording.nc and OUT/forces.csv."""
    from synth import load_scene
    from validation import chain
    from validation.cli.study import show_study
    from validation.run_folder import RunFolder

    terminal = Terminal(json=json)
    with terminal.working():
        chosen = load_scene(scene, quick=quick, seed=seed)
        with RunFolder.create(out) as run:
            work = chain.Work(device, threads)
            chain.simulate(run, chosen, work=work, terminal=terminal, resume=resume, overwrite=overwrite)
            document = step_document(run, "simulate")
        if convergence:
            from validation.studies import find_study
            from validation.studies.carry_out import carry_out
            from validation.studies.convergence import BASE

            place = out / "convergence"
            document["convergence"] = carry_out(
                "convergence",
                find_study("convergence"),
                chosen,
                place,
                quick=quick,
                given={BASE: out},
                resume=resume,
                overwrite=overwrite,
                work=work,
                terminal=terminal,
            )
    terminal.show(f"{run.recording}, {run.forces}")
    if convergence:
        show_study(document["convergence"], place, terminal)
    terminal.give(document)


@app.command()
def render(
    out: RunPath,
    threads: Threads = None,
    device: Device = "cpu",
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Render the pictures of a simulated run, and the truth about them: OUT/footage."""
    from validation import chain
    from validation.run_folder import RunFolder

    terminal = Terminal(json=json)
    with terminal.working(), RunFolder.open(out) as run:
        chain.render(run, work=chain.Work(device, threads), terminal=terminal)
        document = step_document(run, "render")
    terminal.show(str(run.footage))
    terminal.give(document)
