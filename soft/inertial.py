"""Camera motion out: displacement relative to the resting soil (section 2.2)."""

from dataclasses import dataclass

import numpy as np

from soft.far_soil import far_locations
from soft.location import Location, median_location, mode_locations

CAMERA_CHOICES = ("median", "mode", "far")


@dataclass(frozen=True, eq=False)
class InertialMotion:
    """Displacement with the camera's motion taken out.

    Attributes
    ----------
    camera_u, camera_v : float
        Apparent displacement of resting soil in the picture in px, x right and y down: what is subtracted. A
        camera that travels to the right by 3 px sees resting soil move to the left: `camera_u` is -3. NaN
        where no soil pixel was valid; `camera_v` is 0 unless the vertical was asked for.
    camera_u_low, camera_u_high, camera_v_low, camera_v_high : float
        Bounds of their 95 % intervals in px. NaN where the soil is too small to tell, and of a vertical that
        was not asked for. They tell of errors that differ from place to place, not of moving soil taken for
        resting.
    displacement : (H, W, 2) float32
        (u - camera_u, v - camera_v) in px, NaN where the input was.
    """

    camera_u: float
    camera_v: float
    camera_u_low: float
    camera_u_high: float
    camera_v_low: float
    camera_v_high: float
    displacement: np.ndarray


def to_inertial(
    displacement: np.ndarray, soil: np.ndarray, *, vertical: bool = False, camera: str = "median"
) -> InertialMotion:
    """Subtract the displacement of resting soil.

    Parameters
    ----------
    displacement : (H, W, 2) array
        In px; NaN where it was not measured.
    soil : (H, W) bool
        Where soil is.
    vertical : bool, optional
        Take the vertical out too. By default it is left as measured, as in the paper: the carriage travels
        horizontally, and a vertical median would hide soil that settles as a whole.
    camera : str, optional
        `median` over soil, as most soil in view rests (section 2.2); or `mode`, the motion that most soil
        shares, which is right where more than half of it moves, as moving soil moves in many ways; or
        `far`, what motion tends to far from the implement (`soft.far_soil`), which is right where no soil
        in view rests.

    Raises
    ------
    ValueError
        If `camera` is another word.
    """
    if camera not in CAMERA_CHOICES:
        raise ValueError(f"camera: {camera!r}: allowed are {', '.join(CAMERA_CHOICES)}")
    on_soil = np.where((soil & np.isfinite(displacement).all(axis=2))[:, :, None], displacement, np.nan)
    u, v = _located(on_soil, soil, vertical=vertical, camera=camera)
    moved = np.array([u.value, v.value], dtype=np.float32)
    inertial = displacement.astype(np.float32) - moved
    return InertialMotion(u.value, v.value, u.low, u.high, v.low, v.high, inertial)


def _located(
    on_soil: np.ndarray, soil: np.ndarray, *, vertical: bool, camera: str
) -> tuple[Location, Location]:
    as_measured = Location(0.0, np.nan, np.nan)
    if camera == "median":
        across, down = on_soil[:, :, 0], on_soil[:, :, 1]
        return median_location(across), median_location(down) if vertical else as_measured
    u, v = mode_locations(on_soil) if camera == "mode" else far_locations(on_soil, soil)
    return u, v if vertical else as_measured
