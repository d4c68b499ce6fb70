"""Camera motion out: displacement relative to the resting soil (section 2.2)."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class InertialMotion:
    """Displacement with the camera's motion taken out.

    Attributes
    ----------
    camera_u, camera_v : float
        Apparent displacement of resting soil in the picture in px, x right and y down: what is subtracted. A
        camera that travels to the right by 3 px sees resting soil move to the left: `camera_u` is -3. NaN
        where no soil pixel was valid; `camera_v` is 0 unless the vertical was asked for.
    displacement : (H, W, 2) float32
        (u - camera_u, v - camera_v) in px, NaN where the input was.
    """

    camera_u: float
    camera_v: float
    displacement: np.ndarray


def to_inertial(displacement: np.ndarray, soil: np.ndarray, *, vertical: bool = False) -> InertialMotion:
    """Subtract the median displacement over soil, as most soil in view rests (section 2.2).

    Parameters
    ----------
    displacement : (H, W, 2) array
        In px; NaN where it was not measured.
    soil : (H, W) bool
        Where soil is.
    vertical : bool, optional
        Take the vertical median out too. By default the vertical is left as measured, as in the paper: the
        carriage travels horizontally, and a vertical median would hide soil that settles as a whole.
    """
    on_soil = displacement[soil & np.isfinite(displacement).all(axis=2)]
    # A median of nothing is unknown, not zero.
    camera_u = float(np.median(on_soil[:, 0])) if len(on_soil) else float("nan")
    camera_v = 0.0
    if vertical:
        camera_v = float(np.median(on_soil[:, 1])) if len(on_soil) else float("nan")
    camera = np.array([camera_u, camera_v], dtype=np.float32)
    return InertialMotion(camera_u, camera_v, displacement.astype(np.float32) - camera)
