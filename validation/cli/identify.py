"""The command that identifies the force law of wheels on soil."""

from pathlib import Path
from typing import Annotated, Any

import typer

from validation.cli.app import app
from validation.cli.options import Debug, Device, Json, Quick, Resume, Seed, Threads
from validation.terminal import Terminal


@app.command()
def identify(
    out: Annotated[Path, typer.Argument(metavar="OUT", help="A folder; every run is in OUT/runs.")],
    rig: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Measurements of a real single-wheel rig (smooth_wheel.mat).",
            show_default=False,
        ),
    ] = None,
    rover_wheel: Annotated[
        bool, typer.Option("--rover-wheel", help="Simulate a wheel of the rover's own radius, too (slow).")
    ] = False,
    quick: Quick = False,
    seed: Seed = None,
    resume: Resume = True,
    threads: Threads = None,
    device: Device = "cpu",
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Fit the wheel-soil law to wheels rolling in the granular bin; predict a push and a push-rolling cycle.

    Writes OUT/identification.json, .csv and .png. Carried out again, it does only what is missing.
    """
    from synth.scene import SoilBinScene, load_scene
    from validation import chain
    from validation.identification.carry_out import carry_out
    from validation.identification.plan import SCENE

    terminal = Terminal(json=json)
    with terminal.working():
        scene = load_scene(SCENE, quick=quick, seed=seed)
        assert isinstance(scene, SoilBinScene)
        document = carry_out(
            scene,
            out,
            quick=quick,
            rover_wheel=rover_wheel,
            rig=rig,
            work=chain.Work(device, threads),
            terminal=terminal,
            resume=resume,
        )
    _show(document, out, terminal)
    terminal.give(document)


def _show(document: dict[str, Any], out: Path, terminal: Terminal) -> None:
    from validation.identification.table import constants_line, rows_table

    terminal.show(rows_table("steady rolling, fitted", document["steady"]))
    terminal.show(constants_line(document["estimates"]))
    terminal.show(
        rows_table("predicted, not fitted: means over each phase's second half", document["foretold"])
    )
    if document["rover_wheel"]:
        terminal.show(rows_table("the rover's wheel, not fitted", [document["rover_wheel"]]))
    if document["rig"]:
        terminal.show(rows_table("a real rig, fitted to its driven half", document["rig"]["trials"]))
        terminal.show(constants_line(document["rig"]["estimates"]))
    terminal.show(f"{out / 'identification'}.json, .csv, .png")
