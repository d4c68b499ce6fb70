"""Slip, sinkage and forces over time."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SIZE = (9.6, 5.76)  # inch
_ROWS: Sequence[tuple[str, str, float, str]] = (
    ("slip", "slip [%]", 100.0, "#4c78a8"),
    ("sinkage", "sinkage [mm]", 1000.0, "#b07d2b"),
    ("force_x", "drawbar pull [N]", 1.0, "#e45756"),
    ("force_z", "normal force [N]", 1.0, "#54a24b"),
)


def draw_forces(forces: Mapping[str, np.ndarray], *, marked: float | None = None) -> "Figure":
    """Slip, sinkage, drawbar pull and normal force over time.

    Parameters
    ----------
    forces : mapping
        (N,) arrays `time` (s), `slip` (1), `sinkage` (m), `force_x`, `force_z` (N).
    marked : float, optional
        Time of the pair that is shown, s.
    """
    from matplotlib.figure import Figure

    from soft.figures.page import plain_axes

    figure = Figure(figsize=_SIZE, layout="constrained")
    grid = figure.subplots(2, 2, sharex=True).ravel()
    for axes, (name, label, scale, colour) in zip(grid, _ROWS, strict=True):
        values = scale * forces[name]
        plain_axes(axes).plot(forces["time"], values, color=colour, linewidth=1.4)
        axes.set_ylabel(label)
        axes.set_ylim(*_around(values))
        if marked is not None:
            axes.axvline(marked, color="grey", linewidth=0.8, linestyle=":")
    for axes in grid[2:]:
        axes.set_xlabel("time [s]")
    return figure


def _around(values: np.ndarray) -> tuple[float, float]:
    """Limits that show 0, and do not blow up what is constant."""
    low, high = min(0.0, float(np.nanmin(values))), max(0.0, float(np.nanmax(values)))
    room = 0.08 * (high - low) or 1.0
    return low - (room if low < 0 else 0), high + room
