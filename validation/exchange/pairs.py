"""Formats with a file for each picture pair: flo, KITTI, CSV of pixels, CSV of a grid of vectors."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from validation.exchange.field import Field

_MEASURED, _NOT_MEASURED = 0, 1  # as OpenPIV flags


def write(
    fields: Sequence[Field], file_format: str, folder: Path, advance: Callable[[], None], *, stride: int
) -> None:
    """Write `<folder>/<field>/<pair>.<suffix>` for each pair.

    Parameters
    ----------
    file_format : str
        `flo`, `kitti`, `csv` or `grid`.
    advance : callable
        Called after each pair.
    stride : int
        In CSV, every how many pixels one is written.
    """
    suffix, write_pair = _WRITERS[file_format]
    for field in fields:
        (folder / field.name).mkdir()
        for pair in range(field.pair_count):
            write_pair(folder / field.name / f"{pair:06d}{suffix}", field, pair, stride)
            advance()


def _write_flo(path: Path, field: Field, pair: int, stride: int) -> None:
    from soft import write_flo

    write_flo(path, field.displacement(pair))


def _write_kitti(path: Path, field: Field, pair: int, stride: int) -> None:
    from soft import write_kitti

    write_kitti(path, field.displacement(pair))


def _write_pixels(path: Path, field: Field, pair: int, stride: int) -> None:
    """Write a line for each n-th pixel each way whose motion is known."""
    displacement = field.displacement(pair)
    known = np.isfinite(displacement).all(axis=2)
    rows, columns = np.nonzero(known & _every(stride, known.shape))
    _write_table(path, [columns, rows, *displacement[rows, columns].T], "x [px],y [px],u [px],v [px]")


def _write_grid(path: Path, field: Field, pair: int, stride: int) -> None:
    """Write a line for each node, measured or not: those of the method's own grid, else each n-th pixel."""
    displacement, nodes = field.displacement(pair), field.nodes(pair)
    if nodes is None:
        rows, columns = np.nonzero(_every(stride, displacement.shape[:2]))
        places = np.stack([columns, rows], axis=-1)
    else:
        rows, columns = np.nonzero(np.isfinite(nodes).all(axis=2))
        places = nodes[rows, columns]
    vectors = displacement[rows, columns]
    flags = np.where(np.isfinite(vectors).all(axis=1), _MEASURED, _NOT_MEASURED)
    header = "x [px],y [px],u [px],v [px],flags"
    _write_table(path, [*places.T, *vectors.T, flags], header)


def _every(stride: int, shape: tuple[int, int]) -> np.ndarray:
    chosen = np.zeros(shape, bool)
    chosen[stride // 2 :: stride, stride // 2 :: stride] = True
    return chosen


def _write_table(path: Path, columns: Sequence[np.ndarray], header: str) -> None:
    """Nine digits tell every float32 from its neighbours."""
    table = np.column_stack([column.astype(np.float64) for column in columns])
    np.savetxt(path, table, ",".join(["%.9g"] * table.shape[1]), header=header, comments="")


_WRITERS: dict[str, tuple[str, Callable[[Path, Field, int, int], None]]] = {
    "flo": (".flo", _write_flo),
    "kitti": (".png", _write_kitti),
    "csv": (".csv", _write_pixels),
    "grid": (".csv", _write_grid),
}
