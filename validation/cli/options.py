"""Arguments and options that several commands have."""

from pathlib import Path
from typing import Annotated, Literal

import typer

SceneName = Annotated[str, typer.Argument(metavar="SCENE", help="A shipped scene's name or a TOML file.")]
OutFolder = Annotated[Path, typer.Argument(metavar="OUT", help="A run folder; made where there is none.")]
RunPath = Annotated[Path, typer.Argument(metavar="OUT", help="A run folder.")]
Quick = Annotated[bool, typer.Option("--quick", help="The scene's smaller and coarser version.")]
Seed = Annotated[int | None, typer.Option(min=0, metavar="N", help="Another realisation.")]
Threads = Annotated[int | None, typer.Option(min=1, help="Default: every core.", show_default=False)]
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
        help="robust-affine, dis, farneback, tvl1, ilk, package.module:function or files:FOLDER; may repeat.",
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
    Literal["bright", "dark", "all"],
    typer.Option(help="Soil against what surrounds it; all: only soil."),
]
Vertical = Annotated[
    bool, typer.Option("--vertical", help="Take the camera's vertical motion out, too (handheld, settling).")
]
Json = Annotated[bool, typer.Option("--json", help="One JSON document on standard output and nothing else.")]
Debug = Annotated[bool, typer.Option("--debug", help="A full traceback when something fails.")]
