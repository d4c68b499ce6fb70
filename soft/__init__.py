"""Soil optical flow: pictures in, soil flow out.

The public names below are imported on first use, so that ``import soft`` costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from soft.analysis import analyze
    from soft.calibration import CalibrationError
    from soft.averaging import MeanFlow, average_flow
    from soft.averaging_gain import AveragingGain
    from soft.cross_validation import CrossValidation, cross_validate
    from soft.figures import direction_figure, picture_figure, speed_figure, write_figures
    from soft.flow import FlowError, FlowField, estimate_flow, read_flo, read_kitti, write_flo, write_kitti
    from soft.inertial import InertialMotion, to_inertial
    from soft.opening import open_sequence
    from soft.phase_lock import PhaseLockedFlow, grouser_phase, phase_locked_average, wheel_angle_of
    from soft.segmentation import MovingRegion, SoilRegion, moving_mask, soil_mask
    from soft.sequence import ImageSequence, PairSelection, Region, SequenceError
    from soft.settings import AnalysisSettings, SettingsError, write_settings
    from soft.sequence import ImageSequence, SequenceError
    from soft.shear_interface import ShearInterface, shear_interface_of, write_interface
    from soft.soilflow import SoilFlowError, check_soil_flow, read_soil_flow
    from soft.travel import CameraSpeed, camera_speed
    from soft.velocity import to_polar, to_velocity

_HOMES = {
    "AnalysisSettings": "soft.settings",
    "CalibrationError": "soft.calibration",
    "CameraSpeed": "soft.travel",
    "AveragingGain": "soft.averaging_gain",
    "CrossValidation": "soft.cross_validation",
    "FlowError": "soft.flow",
    "FlowField": "soft.flow",
    "ImageSequence": "soft.sequence",
    "InertialMotion": "soft.inertial",
    "MeanFlow": "soft.averaging",
    "MovingRegion": "soft.segmentation",
    "PairSelection": "soft.sequence",
    "Region": "soft.sequence",
    "PhaseLockedFlow": "soft.phase_lock",
    "SequenceError": "soft.sequence",
    "SettingsError": "soft.settings",
    "ShearInterface": "soft.shear_interface",
    "SoilFlowError": "soft.soilflow",
    "SoilRegion": "soft.segmentation",
    "analyze": "soft.analysis",
    "camera_speed": "soft.travel",
    "average_flow": "soft.averaging",
    "check_soil_flow": "soft.soilflow",
    "cross_validate": "soft.cross_validation",
    "direction_figure": "soft.figures",
    "estimate_flow": "soft.flow",
    "grouser_phase": "soft.phase_lock",
    "moving_mask": "soft.segmentation",
    "open_sequence": "soft.opening",
    "phase_locked_average": "soft.phase_lock",
    "picture_figure": "soft.figures",
    "read_flo": "soft.flow",
    "read_kitti": "soft.flow",
    "read_soil_flow": "soft.soilflow",
    "shear_interface_of": "soft.shear_interface",
    "soil_mask": "soft.segmentation",
    "speed_figure": "soft.figures",
    "to_inertial": "soft.inertial",
    "to_polar": "soft.velocity",
    "to_velocity": "soft.velocity",
    "wheel_angle_of": "soft.phase_lock",
    "write_figures": "soft.figures",
    "write_flo": "soft.flow",
    "write_interface": "soft.shear_interface",
    "write_kitti": "soft.flow",
    "write_settings": "soft.settings",
}

__all__ = [
    "AnalysisSettings",
    "CalibrationError",
    "CameraSpeed",
    "AveragingGain",
    "CrossValidation",
    "FlowError",
    "FlowField",
    "ImageSequence",
    "InertialMotion",
    "MeanFlow",
    "MovingRegion",
    "PairSelection",
    "Region",
    "PhaseLockedFlow",
    "SequenceError",
    "SettingsError",
    "ShearInterface",
    "SoilFlowError",
    "SoilRegion",
    "analyze",
    "camera_speed",
    "average_flow",
    "check_soil_flow",
    "cross_validate",
    "direction_figure",
    "estimate_flow",
    "grouser_phase",
    "moving_mask",
    "open_sequence",
    "phase_locked_average",
    "picture_figure",
    "read_flo",
    "read_kitti",
    "read_soil_flow",
    "shear_interface_of",
    "soil_mask",
    "speed_figure",
    "to_inertial",
    "to_polar",
    "to_velocity",
    "wheel_angle_of",
    "write_figures",
    "write_flo",
    "write_interface",
    "write_kitti",
    "write_settings",
]


def __getattr__(name: str) -> object:
    """Import the module that holds `name` on its first use."""
    home = _HOMES.get(name)
    if home is None:
        raise AttributeError(f"module 'soft' has no attribute {name!r}")
    value = getattr(import_module(home), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Public names, imported or not yet."""
    return sorted([*globals(), *__all__])
