"""Figures that need the truth, and those of the report; each a `matplotlib.figure.Figure` of its own."""

from validation.figures.distribution import distribution_figure, draw_histogram
from validation.figures.forces import draw_forces
from validation.figures.maps import (
    draw_direction,
    draw_error,
    draw_picture,
    draw_speed,
    draw_strata,
    to_png,
)
from validation.figures.truth import error_figure, truth_figure

__all__ = [
    "distribution_figure",
    "draw_direction",
    "draw_error",
    "draw_forces",
    "draw_histogram",
    "draw_picture",
    "draw_speed",
    "draw_strata",
    "error_figure",
    "to_png",
    "truth_figure",
]
