"""Figures and films of measurements in the manner of Skonieczny et al. (2014), one function each."""

from soft.figures.colours import COLOURS
from soft.figures.derived import deformation_figure, gain_figure, profile_figure, streamlines_figure
from soft.figures.film import flow_film
from soft.figures.motion import (
    average_figure,
    bucket_figure,
    comparison_figure,
    direction_figure,
    motion_figure,
    picture_figure,
    speed_figure,
)
from soft.figures.page import SUFFIXES, FigureError, save_figure
from soft.figures.segments import segments_figure
from soft.figures.write import write_figures

__all__ = [
    "COLOURS",
    "SUFFIXES",
    "FigureError",
    "average_figure",
    "bucket_figure",
    "comparison_figure",
    "deformation_figure",
    "direction_figure",
    "flow_film",
    "gain_figure",
    "motion_figure",
    "picture_figure",
    "profile_figure",
    "save_figure",
    "segments_figure",
    "speed_figure",
    "streamlines_figure",
    "write_figures",
]
