"""The command that pulls at a vehicle."""

from pathlib import Path
from typing import Annotated

import typer

from validation.cli.app import app
from validation.cli.options import Debug, Json
from validation.terminal import Terminal

_GAITS, _WHEELS = ("rolling", "inching"), ("rigid", "pneumatic")


@app.command()
def drawbar(
    out: Annotated[Path, typer.Argument(metavar="OUT", help="Its folder; made where there is none.")],
    gait: Annotated[
        list[str] | None,
        typer.Option("--gait", metavar="GAIT", help="rolling or inching; may repeat.", show_default="both"),
    ] = None,
    wheel: Annotated[
        list[str] | None,
        typer.Option("--wheel", metavar="WHEEL", help="rigid or pneumatic; may repeat.", show_default="both"),
    ] = None,
    law: Annotated[
        list[str] | None,
        typer.Option(
            "--law",
            metavar="LAW",
            help="rft (resistive force theory), bwj (Bekker-Wong-Janosi), scm (bwj on columns); may repeat.",
            show_default="rft",
        ),
    ] = None,
    load: Annotated[
        list[float] | None,
        typer.Option(
            "--load",
            metavar="RATIO",
            help="Drawbar pull / vehicle weight, rising; may repeat.",
            show_default="steps up to where the vehicle stands",
        ),
    ] = None,
    soil: Annotated[
        Path | None,
        typer.Option(
            "--soil",
            metavar="FILE",
            help="identification.json of softbed identify, for rft.",
            show_default="loose GRC-1, by published values",
        ),
    ] = None,
    vehicle: Annotated[
        str, typer.Option(metavar="NAME", help="A shipped vehicle's name or an MJCF file with named wheels.")
    ] = "scarab",
    speed: Annotated[float, typer.Option(metavar="M/S", help="Of the rim of a rolling wheel.")] = 0.06,
    film: Annotated[
        bool, typer.Option("--film", help="Also a film of one inching cycle at half its pull.")
    ] = False,
    processes: Annotated[
        int | None,
        typer.Option(min=1, metavar="N", help="One curve each.  [default: every core]", show_default=False),
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Measure again what OUT holds.")] = False,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Measure travel reduction against drawbar pull: OUT/drawbar.png, balance.png, drawbar.json, drawbar.csv.

    Carried out again, it measures only what is missing.
    """
    from synth.rover.drawbar import LoadSteps
    from validation.drawbar.curve import CurveOrder
    from validation.drawbar.document import drawbar_document, drawbar_table, ratio_lines
    from validation.drawbar.experiment import carry_out
    from validation.drawbar.files import write_results
    from validation.drawbar.scene_picture import draw_without_display

    draw_without_display()
    terminal = Terminal(json=json)
    steps = LoadSteps(loads=tuple(load or ()))
    orders = [
        CurveOrder(
            vehicle, one_gait, one_wheel, one_law, steps, speed, soil=None if soil is None else str(soil)
        )
        for one_law in law or ["rft"]
        for one_wheel in wheel or _WHEELS
        for one_gait in gait or _GAITS
    ]
    with terminal.working():
        curves = carry_out(orders, out, processes=processes, overwrite=overwrite, terminal=terminal)
        files = write_results(curves, out, film=film, terminal=terminal)
    terminal.show(drawbar_table(curves))
    if lines := ratio_lines(curves):
        terminal.show(lines)
    terminal.show(", ".join(str(file) for file in files))
    terminal.give(drawbar_document(curves))
