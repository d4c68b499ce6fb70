"""Six experiments: picture, true speed, measured speed, error: python docs/make/gallery.py RUNS FILE.jpg.

RUNS has a run folder for each of `SCENES`, with the default method's analysis.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from soft.figures.colours import colour_map, find_colours
from validation.cli.folders import opened_material
from validation.pair_view import PairView
from validation.showing.subject import opened_subject

SCENES = {
    "rolling_wheel": "rolling",
    "pushed_wheel": "pushed",
    "grouser_wheel": "grousers",
    "compliant_wheel": "compliant rim",
    "bucket": "bucket",
    "plate_rotation": "turned plate",
}
TITLES = ("picture", "true speed", "measured speed", "error")
ERROR_TOP = 0.3
"""px: what the published technique keeps within, 95 % of the time, on the turned plate."""


def view_of(path: Path) -> PairView:
    """The run's middle pair with its truth."""
    with opened_material(path, None) as (run, material), opened_subject(path, run, material) as subject:
        return subject.view(subject.require_pair(None))


def cut(values: np.ndarray) -> np.ndarray:
    """The middle half of a square picture's rows, so that all have one form."""
    height, width = values.shape
    rows = min(height, width // 2)
    top = (height - rows) // 2
    return values[top : top + rows]


def draw_row(row: np.ndarray, name: str, view: PairView) -> None:
    """One experiment; both speeds have one scale."""
    (measured,) = view.measured.values()
    fields = (view.truth.speed, measured.motion.speed, measured.error)
    top = float(np.nanpercentile(fields[0], 99.5))
    tops, colours = (top, top, ERROR_TOP), find_colours("even")
    maps = (colours.speed, colours.speed, colours.error)
    for axes in row:
        axes.imshow(cut(view.picture), cmap="gray", vmin=0, vmax=255)
    for axes, field, most, colour in zip(row[1:], fields, tops, maps, strict=True):
        axes.imshow(cut(field), cmap=colour_map(colour), vmin=0, vmax=most, interpolation="nearest")
        told(axes, f"0 to {most:.3g} px")
    row[0].set_ylabel(name, fontsize=11)


def told(axes: Axes, words: str) -> None:
    """What the colours range over."""
    box = {"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 1.5}
    axes.text(0.985, 0.04, words, transform=axes.transAxes, ha="right", fontsize=8, bbox=box)


def gallery(runs: Path) -> Figure:
    """A row for each scene."""
    figure = Figure(figsize=(12, 9.3), layout="constrained")
    grid = figure.subplots(len(SCENES), len(TITLES))
    for row, (scene, name) in zip(grid, SCENES.items(), strict=True):
        draw_row(row, name, view_of(runs / scene))
    for axes, title in zip(grid[0], TITLES, strict=True):
        axes.set_title(title, fontsize=12)
    for axes in grid.ravel():
        axes.set_xticks([])
        axes.set_yticks([])
    return figure


if __name__ == "__main__":
    gallery(Path(sys.argv[1])).savefig(sys.argv[2], dpi=100, pil_kwargs={"quality": 82})
