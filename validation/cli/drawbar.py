"""The command that pulls at a vehicle."""

from pathlib import Path
from typing import Annotated

import typer

from validation.cli.app import app
from validation.cli.options import Debug, Json
from validation.terminal import Terminal

_GAITS = ("rolling", "inching")


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
            show_default="steps up to a travel reduction of 95 %",
        ),
    ] = None,
    soil: Annotated[
        str | None,
        typer.Option(
            "--soil",
            metavar="FILE|dem",
            help="identification.json of softbed identify, for rft; or dem: the grains themselves instead of "
            "a law, rigid wheels, three loads.",
            show_default="loose GRC-1, by published values",
        ),
    ] = None,
    vehicle: Annotated[
        str, typer.Option(metavar="NAME", help="A shipped vehicle's name or an MJCF file with named wheels.")
    ] = "scarab",
    speed: Annotated[
        float | None,
        typer.Option(metavar="M/S", help="Of the rim of a rolling wheel.", show_default="0.06; dem 0.18"),
    ] = None,
    film: Annotated[
        bool, typer.Option("--film", help="Also a film of one inching cycle at half its pull.")
    ] = False,
    glass: Annotated[
        list[Path] | None,
        typer.Option(
            "--glass",
            metavar="RUN",
            help="Run folder of a rolling and one of a pushed wheel: OUT/glass.png, soil beside forces.",
        ),
    ] = None,
    ranges: Annotated[
        bool,
        typer.Option(
            "--range",
            help="Also over the range of what is assumed, rigid wheels, three loads: range.csv.",
        ),
    ] = False,
    repeats: Annotated[
        int,
        typer.Option(
            min=1,
            metavar="N",
            help="Measure each curve so often, its history a little another each time: the maxima's chance.",
        ),
    ] = 1,
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
    from validation.drawbar.chance import chance_table, write_chance
    from validation.drawbar.curve import orders_of, repeated
    from validation.drawbar.document import drawbar_document, drawbar_table, ratio_lines
    from validation.drawbar.experiment import carry_out
    from validation.drawbar.files import write_range, write_results
    from validation.drawbar.glass import runs_by_wheel
    from validation.drawbar.scene_picture import draw_without_display
    from validation.drawbar.variation import range_table, varied_orders

    if film and "inching" not in (gait or _GAITS):
        raise typer.BadParameter("--film shows an inching cycle: --gait inching is needed")
    draw_without_display()
    terminal = Terminal(json=json)
    orders = orders_of(
        vehicle,
        gaits=gait or _GAITS,
        wheels=wheel,
        laws=law,
        loads=load or (),
        speed=speed,
        soil=soil,
    )
    more = repeated(orders, repeats) + (varied_orders(vehicle, gait or _GAITS) if ranges else [])
    with terminal.working():
        seen = runs_by_wheel(glass) if glass else None  # before curves, which take long
        every = carry_out(orders + more, out, processes=processes, overwrite=overwrite, terminal=terminal)
        curves = [curve for curve in every if curve.order in orders]
        again = [curve for curve in every if not curve.order.variation]
        files = write_results(curves, out, film=film, glass=seen, terminal=terminal)
    terminal.show(drawbar_table(curves))
    if ranges:
        over_range = [curve for curve in every if curve.order.variation]
        terminal.show(range_table(over_range))
        files.append(write_range(over_range, out / "range.csv"))
    if repeats > 1:
        terminal.show(chance_table(again))
        files.append(write_chance(again, out / "chance.csv"))
    if lines := ratio_lines(curves):
        terminal.show(lines)
    terminal.show(", ".join(str(file) for file in files))
    terminal.give(drawbar_document(curves))
