"""A picture, and what is known of each of its pixels: python docs/make/labels.py RUN FILE.jpg."""

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from soft.figures.colours import colour_map, find_colours
from synth import Footage
from validation.pair_view import Motion
from validation.scoring.strata import find_strata

TITLES = ("picture", "true speed", "true direction", "complex flow")
COMPLEX = (0.90, 0.0, 0.45, 0.85)
"""Red, green, blue, opacity."""


def labels(run: Path) -> Figure:
    """Of the run's middle pair."""
    with Footage.open(run / "footage") as footage:
        pair = (footage.pair_count - 1) // 2
        picture, truth = footage.picture(pair), footage.truth(pair).load()
    found = find_strata(truth)
    motion, colours = Motion(*found.motion), find_colours("even")
    figure = Figure(figsize=(8, 4.5), layout="constrained")
    axes = figure.subplots(2, 2).ravel()
    for one, title in zip(axes, TITLES, strict=True):
        one.imshow(picture, cmap="gray", vmin=0, vmax=255)
        one.set_title(title, fontsize=12)
        one.set_axis_off()
    axes[1].imshow(
        motion.speed, cmap=colour_map(colours.speed), vmin=0, vmax=np.nanpercentile(motion.speed, 99.5)
    )
    axes[2].imshow(motion.shown_direction, cmap=colour_map(colours.direction), vmin=-np.pi, vmax=np.pi)
    axes[3].imshow(np.where(found.masks["complex"][..., None], COMPLEX, 0.0))
    return figure


if __name__ == "__main__":
    labels(Path(sys.argv[1])).savefig(sys.argv[2], dpi=100, pil_kwargs={"quality": 85})
