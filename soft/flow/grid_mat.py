"""Vectors in MATLAB's `.mat` files: of PIVlab, of GeoPIV-RG (see `trajectories`), and arrays x, y, u, v.

PIVlab keeps one array a picture pair in cells: `x`, `y`, `u_filtered` and `v_filtered` or, where that is
empty, `u_original` and `v_original`, each with a `typevector_...` (1 = measured, 0 = masked, 2 =
interpolated).
"""

from pathlib import Path
from typing import Any

import numpy as np

from soft.flow.field import FlowError
from soft.flow.grid import Grid
from soft.flow.mat_file import read_mat
from soft.flow.trajectories import count_steps, holds_trajectories, read_step

_SUFFIXES = ("_filtered", "_original", "")
_SCALES = ("calxy", "calu", "calv", "caluv")
"""PIVlab's factors from px to m and from px/frame to m/s: 1 (or, for an axis turned round, -1) in px."""


def count_grids(path: Path) -> int:
    """How many picture pairs a file tells of."""
    content = read_mat(path)
    if holds_trajectories(content):
        return count_steps(content, path)
    return len(_as_cells(content, "x", path))


def read_mat_grid(path: Path, index: int) -> Grid:
    """Vectors of the picture pair `index` of a file.

    Raises
    ------
    FlowError
        If it is no such file, lacks a variable, tells of fewer pairs, or is not in px.
    """
    content = read_mat(path)
    if holds_trajectories(content):
        return read_step(content, index, path)
    _require_pixels(content, path)
    suffix = next((s for s in _SUFFIXES if _size(content, f"u{s}", index)), None)
    if suffix is None:
        held = ", ".join(sorted(content)) or "nothing"
        raise FlowError(f"{path}: no vectors of pair {index} in u_filtered, u_original or u: holds {held}")
    names = ["x", "y", f"u{suffix}", f"v{suffix}"]
    x, y, u, v = (_array(content, name, index, path) for name in names)
    if x.ndim == 2 and 1 in x.shape and 1 in y.shape and u.shape == (y.size, x.size):
        x, y = np.meshgrid(x.ravel(), y.ravel())
    for name, values in zip(names, (x, y, u, v), strict=True):
        if values.shape != u.shape:
            raise FlowError(f"{path}: {name}: shape {values.shape}: {names[2]} has {u.shape}")
    measured = np.ones(u.shape, bool)
    if _size(content, f"typevector{suffix}", index):
        measured = _array(content, f"typevector{suffix}", index, path) == 1
        if measured.shape != u.shape:
            raise FlowError(f"{path}: typevector{suffix}: shape {measured.shape}: {names[2]} has {u.shape}")
    return Grid(x.ravel(), y.ravel(), u.ravel(), v.ravel(), measured.ravel())


def _as_cells(content: dict[str, Any], name: str, path: Path) -> list[np.ndarray]:
    """What a cell array holds, or, where it is none, the array itself."""
    if name not in content:
        raise FlowError(f"{path}: no variable {name}")
    value = np.asarray(content[name])
    return [np.asarray(cell) for cell in value.ravel()] if value.dtype == object else [value]


def _size(content: dict[str, Any], name: str, index: int) -> int:
    if name not in content:
        return 0
    cells = _as_cells(content, name, Path())
    return cells[index].size if index < len(cells) else 0


def _array(content: dict[str, Any], name: str, index: int, path: Path) -> np.ndarray:
    cells = _as_cells(content, name, path)
    # Places may be told once for all pairs.
    cell = cells[index if len(cells) > 1 else 0] if index < len(cells) or len(cells) == 1 else None
    if cell is None or cell.dtype.kind not in "fiub":
        raise FlowError(f"{path}: {name}: must hold real numbers for pair {index}")
    return cell.astype(float)


def _require_pixels(content: dict[str, Any], path: Path) -> None:
    for name in _SCALES:
        if name in content:
            value = float(np.asarray(content[name], dtype=float).ravel()[0])
            if abs(value) != 1:
                raise FlowError(f"{path}: {name} = {value:g}: must be px (export before calibration)")
