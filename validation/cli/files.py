"""Commands about the files of a run: export, check."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from validation.cli.app import CHECK_FAILED, app
from validation.cli.folders import opened_material, step_document
from validation.cli.options import Debug, Json, Out
from validation.terminal import Terminal


@app.command()
def export(
    path: Annotated[
        Path,
        typer.Argument(metavar="OUT", help="A run folder, footage, or pictures that have been analyzed."),
    ],
    file_format: Annotated[
        Literal["vtk", "flo", "kitti", "netcdf", "csv", "grid", "vti", "mp4"],
        typer.Option(
            "--format",
            help="vtk: grains, implement and contacts for ParaView. The others: truth and measured motion; "
            "vti for ParaView, grid as PIV programs have it; kitti rounds to 1/64 px, mp4 is a film of each.",
        ),
    ] = "vtk",
    stride: Annotated[
        int | None,
        typer.Option(
            min=1, help="csv, grid: every how many pixels one is written. Default: 1, 16.", show_default=False
        ),
    ] = None,
    out: Out = None,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Write what was simulated or measured in a format of other programs: OUT/FORMAT."""
    from validation import chain
    from validation.exchange import STRIDES
    from validation.run_folder import RunFolder

    if stride is not None and file_format not in STRIDES:
        raise typer.BadParameter(f"--stride: {file_format} has every pixel: only for {', '.join(STRIDES)}")
    terminal = Terminal(json=json)
    with terminal.working():
        if file_format == "vtk":
            with RunFolder.open(path) as run:
                chain.export_vtk(run, terminal=terminal)
        else:
            with opened_material(path, out) as (run, material):
                chain.export_fields(run, material, file_format, stride=stride, terminal=terminal)
        document = step_document(run, f"export {file_format}")
    terminal.show(_exported(run.path / file_format))
    terminal.give(document)


def _exported(folder: Path) -> str:
    """Name what lies in a folder, to open first."""
    series = sorted(folder.glob("*.pvd"))
    return ", ".join(map(str, series or sorted(folder.iterdir())))


@app.command()
def check(
    path: Annotated[Path, typer.Argument(metavar="OUT", help="A run folder, or a footage folder.")],
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Verify hashes and form of every file, and name what is wrong; exit status 1 where something is."""
    from validation.check import check_folder

    terminal = Terminal(json=json)
    with terminal.working(), terminal.progress("check") as progress:
        findings = check_folder(path, progress=progress)
    terminal.show(str(findings))
    terminal.give(findings.to_dict())
    if findings.faults:
        raise typer.Exit(CHECK_FAILED)
