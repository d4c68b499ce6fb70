"""Arguments and options that several commands have."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from soft.flow.registry import method_names

BUILT_IN_METHODS = ", ".join(method_names())

SceneName = Annotated[str, typer.Argument(metavar="SCENE", help="A shipped scene's name or a TOML file.")]
OutFolder = Annotated[Path, typer.Argument(metavar="OUT", help="A run folder; made where there is none.")]
RunPath = Annotated[Path, typer.Argument(metavar="OUT", help="A run folder.")]
Quick = Annotated[bool, typer.Option("--quick", help="The scene's smaller and coarser version.")]
Seed = Annotated[int | None, typer.Option(min=0, metavar="N", help="Another realisation.")]
Threads = Annotated[int | None, typer.Option(min=1, help="Default: every core.", show_default=False)]
Processes = Annotated[
    int, typer.Option(min=1, metavar="N", help="That analyze N pairs at a time, and share the threads.")
]
Resume = Annotated[
    bool, typer.Option("--resume/--no-resume", help="Go on where a killed simulation left a checkpoint.")
]
Overwrite = Annotated[
    bool, typer.Option("--overwrite", help="Replace another scene's or seed's run that OUT holds.")
]
Device = Annotated[Literal["cpu", "cuda"], typer.Option(help="Where kernels run.")]
Methods = Annotated[
    list[str] | None,
    typer.Option(
        "--method",
        metavar="METHOD",
        help=f"{BUILT_IN_METHODS}, package.module:function or files:FOLDER; may repeat.",
        show_default=False,
    ),
]
Out = Annotated[
    Path | None,
    typer.Option("--out", metavar="DIR", help="Default: PATH if it is a run folder, else ./<name>-softbed."),
]
MetresPerPixel = Annotated[
    float | None, typer.Option(help="Size of a pixel on the glass, m.", show_default=False)
]
FrameRate = Annotated[float | None, typer.Option(help="Pictures a second.", show_default=False)]
Soil = Annotated[
    Literal["bright", "dark", "all"] | None,
    typer.Option(
        help="Soil against what surrounds it; all: only soil.  [default: bright]", show_default=False
    ),
]
Vertical = Annotated[
    bool | None,
    typer.Option(
        "--vertical/--no-vertical",
        help="Take the camera's vertical motion out, too (handheld, settling).",
        show_default=False,
    ),
]
Camera = Annotated[
    Literal["median", "mode", "far"] | None,
    typer.Option(
        help="Its motion: median over soil; or, where over half of it moves, what most soil shares (mode), "
        "or what motion tends to far from the implement (far).  [default: median]",
        show_default=False,
    ),
]
Settings = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="A TOML file of settings; options go before it.", show_default=False),
]
Start = Annotated[
    int | None, typer.Option(metavar="N", help="Frame of the first pair; the first is 0.", show_default=False)
]
Stop = Annotated[
    int | None, typer.Option(metavar="N", help="Frames from this one on are not used.", show_default=False)
]
Stride = Annotated[
    int | None,
    typer.Option(metavar="N", help="Frames from a pair's first picture to its second.", show_default=False),
]
Every = Annotated[
    int | None,
    typer.Option(metavar="N", help="Frames from one pair's first to the next pair's.", show_default=False),
]
RegionText = Annotated[
    str | None,
    typer.Option(
        "--region", metavar="X,Y,W,H", help="Only this part of the picture, px.", show_default=False
    ),
]
Masks = Annotated[
    Path | None,
    typer.Option(
        metavar="PATH",
        help="A picture for all frames, or a folder of one each: black is never soil.",
        show_default=False,
    ),
]
LensFile = Annotated[
    Path | None,
    typer.Option("--lens", metavar="FILE", help="A lens file: distortion is taken out.", show_default=False),
]
Json = Annotated[bool, typer.Option("--json", help="One JSON document on standard output and nothing else.")]
Debug = Annotated[bool, typer.Option("--debug", help="A full traceback when something fails.")]
