"""Soil optical flow: pictures in, soil flow out.

The public names below are imported on first use, so that ``import soft`` costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from soft.analysis import analyze
    from soft.averaging import MeanFlow, average_flow
    from soft.averaging_gain import AveragingGain
    from soft.calibration import CalibrationError
    from soft.cross_validation import CrossValidation, cross_validate
    from soft.deformation import Deformation, deformation_of
    from soft.direction_filter import direction_of, significant_direction
    from soft.figures import (
        FigureError,
        average_figure,
        bucket_figure,
        comparison_figure,
        deformation_figure,
        direction_figure,
        flow_film,
        gain_figure,
        motion_figure,
        picture_figure,
        profile_figure,
        save_figure,
        segments_figure,
        speed_figure,
        streamlines_figure,
        write_figures,
    )
    from soft.flow import (
        FlowError,
        FlowField,
        estimate_flow,
        read_flo,
        read_kitti,
        write_flo,
        write_kitti,
    )
    from soft.gradient import displacement_gradient
    from soft.inertial import InertialMotion, to_inertial
    from soft.opening import open_sequence
    from soft.pair_motion import PairMotion, motion_between_nodes, motion_of_pair
    from soft.phase_lock import PhaseLockedFlow, grouser_phase, phase_locked_average, wheel_angle_of
    from soft.segmentation import MovingRegion, SoilRegion, moving_mask, soil_mask
    from soft.sequence import ImageSequence, PairSelection, Region, SequenceError
    from soft.settings import AnalysisSettings, SettingsError, write_settings
    from soft.shear_interface import (
        ShearInterface,
        shear_interface_of,
        shear_interface_of_mean,
        write_interface,
    )
    from soft.soil_motion import (
        DirectionStatistics,
        FailureDepth,
        Flux,
        ThrustShares,
        VelocityProfile,
        direction_statistics,
        failure_depth,
        forward_flux,
        thrust_shares,
        velocity_profile,
    )
    from soft.soilflow import SoilFlowError, check_soil_flow, read_soil_flow
    from soft.streamlines import Streamlines, trace_streamlines
    from soft.travel import CameraSpeed, camera_speed
    from soft.vector_field import vector_field
    from soft.velocity import to_polar, to_velocity

_HOMES = {
    "AnalysisSettings": "soft.settings",
    "AveragingGain": "soft.averaging_gain",
    "CalibrationError": "soft.calibration",
    "CameraSpeed": "soft.travel",
    "CrossValidation": "soft.cross_validation",
    "Deformation": "soft.deformation",
    "DirectionStatistics": "soft.soil_motion",
    "FailureDepth": "soft.soil_motion",
    "FigureError": "soft.figures",
    "FlowError": "soft.flow",
    "FlowField": "soft.flow",
    "Flux": "soft.soil_motion",
    "ImageSequence": "soft.sequence",
    "InertialMotion": "soft.inertial",
    "MeanFlow": "soft.averaging",
    "MovingRegion": "soft.segmentation",
    "PairMotion": "soft.pair_motion",
    "PairSelection": "soft.sequence",
    "PhaseLockedFlow": "soft.phase_lock",
    "Region": "soft.sequence",
    "SequenceError": "soft.sequence",
    "SettingsError": "soft.settings",
    "ShearInterface": "soft.shear_interface",
    "SoilFlowError": "soft.soilflow",
    "SoilRegion": "soft.segmentation",
    "Streamlines": "soft.streamlines",
    "ThrustShares": "soft.soil_motion",
    "VelocityProfile": "soft.soil_motion",
    "analyze": "soft.analysis",
    "average_figure": "soft.figures",
    "average_flow": "soft.averaging",
    "bucket_figure": "soft.figures",
    "camera_speed": "soft.travel",
    "check_soil_flow": "soft.soilflow",
    "comparison_figure": "soft.figures",
    "cross_validate": "soft.cross_validation",
    "deformation_figure": "soft.figures",
    "deformation_of": "soft.deformation",
    "direction_figure": "soft.figures",
    "direction_of": "soft.direction_filter",
    "direction_statistics": "soft.soil_motion",
    "displacement_gradient": "soft.gradient",
    "estimate_flow": "soft.flow",
    "failure_depth": "soft.soil_motion",
    "flow_film": "soft.figures",
    "forward_flux": "soft.soil_motion",
    "gain_figure": "soft.figures",
    "grouser_phase": "soft.phase_lock",
    "motion_figure": "soft.figures",
    "motion_between_nodes": "soft.pair_motion",
    "motion_of_pair": "soft.pair_motion",
    "moving_mask": "soft.segmentation",
    "open_sequence": "soft.opening",
    "phase_locked_average": "soft.phase_lock",
    "picture_figure": "soft.figures",
    "profile_figure": "soft.figures",
    "read_flo": "soft.flow",
    "read_kitti": "soft.flow",
    "read_soil_flow": "soft.soilflow",
    "save_figure": "soft.figures",
    "segments_figure": "soft.figures",
    "shear_interface_of": "soft.shear_interface",
    "shear_interface_of_mean": "soft.shear_interface",
    "significant_direction": "soft.direction_filter",
    "soil_mask": "soft.segmentation",
    "speed_figure": "soft.figures",
    "streamlines_figure": "soft.figures",
    "thrust_shares": "soft.soil_motion",
    "to_inertial": "soft.inertial",
    "to_polar": "soft.velocity",
    "to_velocity": "soft.velocity",
    "trace_streamlines": "soft.streamlines",
    "vector_field": "soft.vector_field",
    "velocity_profile": "soft.soil_motion",
    "wheel_angle_of": "soft.phase_lock",
    "write_figures": "soft.figures",
    "write_flo": "soft.flow",
    "write_interface": "soft.shear_interface",
    "write_kitti": "soft.flow",
    "write_settings": "soft.settings",
}

__all__ = [
    "AnalysisSettings",
    "AveragingGain",
    "CalibrationError",
    "CameraSpeed",
    "CrossValidation",
    "Deformation",
    "DirectionStatistics",
    "FailureDepth",
    "FigureError",
    "FlowError",
    "FlowField",
    "Flux",
    "ImageSequence",
    "InertialMotion",
    "MeanFlow",
    "MovingRegion",
    "PairMotion",
    "PairSelection",
    "PhaseLockedFlow",
    "Region",
    "SequenceError",
    "SettingsError",
    "ShearInterface",
    "SoilFlowError",
    "SoilRegion",
    "Streamlines",
    "ThrustShares",
    "VelocityProfile",
    "analyze",
    "average_figure",
    "average_flow",
    "bucket_figure",
    "camera_speed",
    "check_soil_flow",
    "comparison_figure",
    "cross_validate",
    "deformation_figure",
    "deformation_of",
    "direction_figure",
    "direction_of",
    "direction_statistics",
    "displacement_gradient",
    "estimate_flow",
    "failure_depth",
    "flow_film",
    "forward_flux",
    "gain_figure",
    "grouser_phase",
    "motion_between_nodes",
    "motion_figure",
    "motion_of_pair",
    "moving_mask",
    "open_sequence",
    "phase_locked_average",
    "picture_figure",
    "profile_figure",
    "read_flo",
    "read_kitti",
    "read_soil_flow",
    "save_figure",
    "segments_figure",
    "shear_interface_of",
    "shear_interface_of_mean",
    "significant_direction",
    "soil_mask",
    "speed_figure",
    "streamlines_figure",
    "thrust_shares",
    "to_inertial",
    "to_polar",
    "to_velocity",
    "trace_streamlines",
    "vector_field",
    "velocity_profile",
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
