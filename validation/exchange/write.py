"""Writing fields in any of the formats."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from validation.exchange.field import Field

if TYPE_CHECKING:
    from soft import ImageSequence

FORMATS = {
    "flo": "Middlebury, float32",
    "kitti": "KITTI, 16-bit PNG, rounded to 1/64 px",
    "netcdf": "CF netCDF-4, float32, pictures too",
    "csv": "x, y, u, v; a line for each pixel whose motion is known",
    "grid": "CSV of a grid of vectors: x, y, u, v, flags, as PIV programs have it",
    "vti": "images with vectors and masks for ParaView: open the .pvd",
}
STRIDES = {"csv": 1, "grid": 16}
"""Every how many pixels one is written, px, where that can be chosen."""

Progress = Callable[[int, int], None]


def write_fields(
    fields: Sequence[Field],
    sequence: "ImageSequence",
    file_format: str,
    folder: Path,
    *,
    stride: int | None = None,
    progress: Progress | None = None,
) -> None:
    """Write fields in one of `FORMATS`.

    Parameters
    ----------
    fields : sequence of Field
    sequence : soft.ImageSequence
        The pictures they are of.
    file_format : str
        A key of `FORMATS`.
    folder : Path
        Where to; must exist.
    stride : int, optional
        For formats of `STRIDES`, every how many pixels one is written.
    progress : callable, optional
        Called with the pairs done and the pairs in all.

    Raises
    ------
    soft.FlowError
        A displacement that the format cannot hold.
    """
    from validation.exchange import netcdf, pairs, paraview

    steps = Steps(sum(field.pair_count for field in fields), progress)
    if file_format == "netcdf":
        netcdf.write(fields, sequence, folder, steps.advance)
    elif file_format == "vti":
        paraview.write(fields, sequence, folder, steps.advance)
    else:
        step = stride or STRIDES.get(file_format, 1)
        pairs.write(fields, file_format, folder, steps.advance, stride=step)


class Steps:
    """Counts pairs over all fields."""

    def __init__(self, total: int, progress: Progress | None) -> None:
        self._done, self._total, self._progress = 0, total, progress

    def advance(self) -> None:
        """One more pair is done."""
        self._done += 1
        if self._progress is not None:
            self._progress(self._done, self._total)
