"""Displacement between two pictures: `estimate_flow` and its estimators.

The public names below are imported on first use, so that `soft.flow.registry` alone costs nothing.
"""

from typing import TYPE_CHECKING

from soft.lazy_names import lazy_names

if TYPE_CHECKING:
    from soft.flow.estimate import DEFAULT, estimate_flow, resolve_options
    from soft.flow.field import FlowError, FlowField
    from soft.flow.files import FlowFiles
    from soft.flow.flo import read_flo, write_flo
    from soft.flow.kitti import read_kitti, write_kitti
    from soft.flow.registry import BUILT_IN, NEEDS, VARIANTS, find_estimator, installed, method_names

_HOMES = {
    "BUILT_IN": "soft.flow.registry",
    "DEFAULT": "soft.flow.estimate",
    "NEEDS": "soft.flow.registry",
    "VARIANTS": "soft.flow.registry",
    "FlowError": "soft.flow.field",
    "FlowField": "soft.flow.field",
    "FlowFiles": "soft.flow.files",
    "estimate_flow": "soft.flow.estimate",
    "find_estimator": "soft.flow.registry",
    "installed": "soft.flow.registry",
    "method_names": "soft.flow.registry",
    "read_flo": "soft.flow.flo",
    "read_kitti": "soft.flow.kitti",
    "resolve_options": "soft.flow.estimate",
    "write_flo": "soft.flow.flo",
    "write_kitti": "soft.flow.kitti",
}

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
    "method_names",
    "read_flo",
    "read_kitti",
    "resolve_options",
    "write_flo",
    "write_kitti",
]

__getattr__, __dir__ = lazy_names(__name__, _HOMES)
