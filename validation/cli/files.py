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
        typer.Argument(
            metavar="OUT", help="A run folder, footage, pictures that have been analyzed, or a data set."
        ),
    ],
    file_format: Annotated[
        Literal["vtk", "flo", "kitti", "netcdf", "csv", "grid", "vti", "mp4", "sintel", "kitti-flow"],
        typer.Option(
            "--format",
            help="vtk: grains, implement and contacts for ParaView. The others: truth and measured motion; "
            "vti for ParaView, grid as PIV programs have it; kitti rounds to 1/64 px, mp4 is a film of each. "
            "Of a data set: sintel, kitti-flow, as flow networks' loaders read it, a root for each split.",
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
    if file_format in ("sintel", "kitti-flow"):
        _export_data_set(path, file_format, out, terminal)
        return
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


def _export_data_set(path: Path, layout: str, out: Path | None, terminal: Terminal) -> None:
    from validation.chain.data_set import export_data_set

    with terminal.working():
        folder = export_data_set(path, layout, out, terminal=terminal)
    roots = sorted(folder.iterdir())
    terminal.show(", ".join(map(str, roots)))
    terminal.give({"schema_version": 1, "folder": str(folder), "roots": [root.name for root in roots]})


def _exported(folder: Path) -> str:
    """Name what lies in a folder, to open first."""
    series = sorted(folder.glob("*.pvd"))
    return ", ".join(map(str, series or sorted(folder.iterdir())))


@app.command()
def check(
    path: Annotated[
        Path, typer.Argument(metavar="OUT", help="A run folder, a footage folder, or a data set.")
    ],
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
