"""Commands for looking at pictures."""

from pathlib import Path
from typing import Annotated

import typer

from validation.cli.app import app
from validation.cli.options import Debug, Device, Json, Resume, Threads
from validation.terminal import Terminal


@app.command("compare-pictures")
def compare_pictures(
    a: Annotated[Path, typer.Argument(metavar="A", help="A picture, or a folder of pictures.")],
    b: Annotated[Path, typer.Argument(metavar="B", help="What to set beside it.")],
    crop_a: Annotated[
        str | None, typer.Option(metavar="X,Y,W,H", help="Only this part of A, px.", show_default=False)
    ] = None,
    crop_b: Annotated[
        str | None, typer.Option(metavar="X,Y,W,H", help="Only this part of B, px.", show_default=False)
    ] = None,
    bin_a: Annotated[int, typer.Option(min=1, max=64, metavar="N", help="Make N x N px of A one.")] = 1,
    bin_b: Annotated[int, typer.Option(min=1, max=64, metavar="N", help="Make N x N px of B one.")] = 1,
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="The figure to write, a PNG.")] = Path(
        "compare-pictures.png"
    ),
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Set grey levels, grain size, spectrum, gradient and noise of pictures side by side."""
    from soft import Region
    from soft.figures.page import require_suffix
    from validation import compare_pictures as compare
    from validation.figures import to_png

    require_suffix(out, (".png",))
    terminal = Terminal(json=json)
    with terminal.working():
        given = (("--crop-a", crop_a), ("--crop-b", crop_b))
        regions = [None if text is None else Region.parse(text, name=name) for name, text in given]
        first, second = (
            compare.picture_statistics(compare.read_pictures(path, region, binning=side), path.name)
            for path, region, side in zip((a, b), regions, (bin_a, bin_b), strict=True)
        )
        out.write_bytes(to_png(compare.draw_comparison(first, second)))
    terminal.show("\n".join([*compare.comparison_lines(first, second), f"figure: {out}"]))
    terminal.give(compare.comparison_document(first, second, out))


@app.command("contact-sheet")
def contact_sheet(
    out: Annotated[Path, typer.Argument(metavar="OUT", help="A folder; every run is in OUT/runs.")],
    scene: Annotated[
        list[str] | None,
        typer.Option("--scene", metavar="SCENE", help="Only this one; may repeat.", show_default=False),
    ] = None,
    run: Annotated[
        list[Path] | None,
        typer.Option(
            "--run",
            metavar="OUT",
            help="A run folder elsewhere, quick, whose recording stands for its scene; may repeat.",
            show_default=False,
        ),
    ] = None,
    resume: Resume = True,
    threads: Threads = None,
    device: Device = "cpu",
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Lay out a picture of every shipped scene, clean and disturbed: OUT/contact-sheet.jpg.

    Scenes are simulated in their quick versions. Called again, it does only what is missing.
    """
    from synth import scene_names
    from validation import chain
    from validation.contact_sheet import make_contact_sheet
    from validation.manifest import Manifest

    terminal = Terminal(json=json)
    with terminal.working():
        names = scene or [*scene_names()]
        given = {Manifest.read(path).scene: path for path in run or []}
        work = chain.Work(device, threads)
        sheet = make_contact_sheet(out, names, given=given, resume=resume, work=work, terminal=terminal)
    terminal.show(str(sheet))
    terminal.give({"schema_version": 1, "sheet": str(sheet), "scenes": names})
