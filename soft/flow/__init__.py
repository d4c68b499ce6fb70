"""Displacement between two pictures: `estimate_flow` and its estimators."""

from soft.flow.estimate import DEFAULT, estimate_flow, resolve_options
from soft.flow.field import FlowError, FlowField
from soft.flow.files import FlowFiles
from soft.flow.flo import read_flo, write_flo
from soft.flow.kitti import read_kitti, write_kitti
from soft.flow.registry import BUILT_IN, NEEDS, VARIANTS, find_estimator, installed

__all__ = [
    "BUILT_IN",
    "DEFAULT",
    "NEEDS",
    "VARIANTS",
    "FlowError",
    "FlowField",
    "FlowFiles",
    "estimate_flow",
    "find_estimator",
    "installed",
    "read_flo",
    "read_kitti",
    "resolve_options",
    "write_flo",
    "write_kitti",
]
