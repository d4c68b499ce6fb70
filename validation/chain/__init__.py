"""The steps from a scene to a scored report, each skipped where its result is there and whole."""

from validation.chain.analysis import analyze, analyzed_methods, draw, methods_to_score, require_methods
from validation.chain.exporting import export_fields, export_vtk
from validation.chain.rendering import footage_of, render
from validation.chain.scoring import report, require_truth, score
from validation.chain.simulation import run_scene, simulate
from validation.chain.step import Work

__all__ = [
    "Work",
    "analyze",
    "analyzed_methods",
    "draw",
    "export_fields",
    "export_vtk",
    "footage_of",
    "methods_to_score",
    "render",
    "report",
    "require_methods",
    "require_truth",
    "run_scene",
    "score",
    "simulate",
]
