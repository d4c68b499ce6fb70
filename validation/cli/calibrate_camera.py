"""The command that calibrates a camera's lens."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from validation.cli.app import app
from validation.cli.options import Debug, Json
from validation.terminal import Progress, Terminal

if TYPE_CHECKING:
    import numpy as np


@app.command("calibrate-camera")
def calibrate_camera(
    pictures: Annotated[Path, typer.Argument(metavar="PICTURES", help="A folder of photographs of a board.")],
    board: Annotated[
        str,
        typer.Option(
            metavar="BOARD",
            help="chessboard:9x6:0.025 (inner corners, square in m) or charuco:11x8:0.02:0.015:DICT_5X5_100 "
            "(squares, square and marker in m, dictionary).",
        ),
    ],
    output: Annotated[Path, typer.Option("--output", metavar="FILE", help="The lens file to write.")],
    radial_terms: Annotated[
        int, typer.Option(min=2, max=3, help="3 for wide-angle lenses, and many pictures.")
    ] = 2,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Find a camera's lens distortion from photographs of a board: a file for `analyze --lens`."""
    from soft.calibration import calibrate_lens, parse_board
    from soft.sequence.folder import sorted_pictures

    terminal = Terminal(json=json)
    with terminal.working(), terminal.progress("find the board") as progress:
        wanted = parse_board(board)
        files = sorted_pictures(pictures)
        lens = calibrate_lens(_read(files, progress), wanted, radial_terms=radial_terms)
        lens.write(output)
    unseen = [file.name for file in files if file.name not in lens.views]
    if unseen:
        terminal.say(f"the board is not seen in: {', '.join(unseen)}")
    k1, k2, p1, p2, k3 = lens.distortion
    terminal.show(
        f"{len(lens.views)} of {len(files)} pictures, corners off by {lens.reprojection_error:.3f} px (rms); "
        f"k1 {k1:.4f}, k2 {k2:.4f}, p1 {p1:.5f}, p2 {p2:.5f}, k3 {k3:.4f}\n{output}"
    )
    terminal.give(
        {
            "schema_version": 1,
            "file": str(output),
            "views": list(lens.views),
            "unseen": unseen,
            "reprojection_error": lens.reprojection_error,
            "camera_matrix": lens.camera_matrix.tolist(),
            "distortion": lens.distortion.tolist(),
        }
    )


def _read(files: list[Path], progress: Progress) -> "Iterator[tuple[str, np.ndarray]]":
    """Pictures by name, one at a time."""
    from soft.sequence import read_picture

    for k, file in enumerate(files):
        progress(k, len(files))
        yield file.name, read_picture(file)
