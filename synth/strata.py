"""Which pixels belong together when errors are told: all, moving, complex, quiet, mixed.

The strata come from the truth alone, so that every method is judged on the same pixels.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

STRATA = ("all", "moving", "complex", "quiet", "mixed")
MEANINGS = {
    "all": "every pixel of soil whose true motion is known",
    "moving": "soil whose true motion in the inertial frame is above 1 px",
    "complex": "soil within 3 px of the implement, or of a true gradient of motion above 0.1 px/px",
    "quiet": "soil that is neither moving nor complex",
    "mixed": "soil whose pixel holds motions more than 0.1 px apart",
}
MOVING_ABOVE = 1.0
"""True inertial motion above which soil is moving, px."""
COMPLEX_WITHIN = 3.0
"""Distance to the implement, or to a steep gradient, within which flow is complex, px."""
COMPLEX_ABOVE = 0.1
"""Frobenius norm of the true displacement's gradient above which flow is complex, px/px."""


@dataclass(frozen=True, eq=False)
class Strata:
    """Masks of one picture pair, (H, W) bool each, and the motion they rest on.

    Attributes
    ----------
    masks : dict
        A mask for every name of `STRATA`.
    camera_u, camera_v : float
        Displacement of resting soil by the camera's own motion, right and down, px.
    motion : (2, H, W) array
        Displacement of soil without it, px; NaN elsewhere.
    """

    masks: dict[str, np.ndarray]
    camera_u: float
    camera_v: float
    motion: np.ndarray

    @property
    def speed(self) -> np.ndarray:
        """Magnitude of the inertial motion, (H, W) px; NaN where there is no soil."""
        return np.hypot(*self.motion)


def find_strata(truth: "xr.Dataset") -> Strata:
    """Sort the pixels of one picture pair.

    Parameters
    ----------
    truth : xarray.Dataset
        Over `y, x`: `u`, `v` (px), `valid`, `soil`, `mixed`, `distance_to_implement` (px), and
        `camera_u`, `camera_v` (px) if they are told.
    """
    u, v = truth["u"].values, truth["v"].values
    everything = truth["soil"].values & truth["valid"].values & np.isfinite(u) & np.isfinite(v)
    camera_u, camera_v = camera_displacement(truth, everything)
    motion = np.where(everything, np.stack([u - camera_u, v - camera_v]), np.nan)
    with np.errstate(invalid="ignore"):
        moving = np.hypot(*motion) > MOVING_ABOVE
    near = truth["distance_to_implement"].values <= COMPLEX_WITHIN
    steep = gradient_norm(u, v, everything) > COMPLEX_ABOVE
    complicated = everything & (near | (distance_to(steep) <= COMPLEX_WITHIN))
    masks = {
        "all": everything,
        "moving": moving,
        "complex": complicated,
        "quiet": everything & ~moving & ~complicated,
        "mixed": everything & truth["mixed"].values,
    }
    return Strata(masks, camera_u, camera_v, motion)


def distance_to(mask: np.ndarray) -> np.ndarray:
    """Distance of every pixel's centre to the nearest one of a mask, px: (H, W), infinite without any."""
    from scipy.ndimage import distance_transform_edt

    return distance_transform_edt(~mask) if mask.any() else np.full(mask.shape, np.inf)


def camera_displacement(truth: "xr.Dataset", soil: np.ndarray) -> tuple[float, float]:
    """Displacement that the camera's own motion gives to resting soil, right and down, px.

    As the truth tells it (`camera_u`, `camera_v`); where it does not, the horizontal median over all soil,
    which is how the soil optical flow technique finds it (Skonieczny et al. 2014, section 2.2) and right
    where most soil rests, and no vertical motion.

    Parameters
    ----------
    truth : xarray.Dataset
        Over `y, x`, one picture pair.
    soil : (H, W) bool array
        Soil whose motion is known.

    Returns
    -------
    float, float
        0 where there is no soil.
    """
    camera_v = float(truth["camera_v"]) if "camera_v" in truth else 0.0
    if "camera_u" in truth:
        return float(truth["camera_u"]), camera_v
    return float(np.median(truth["u"].values[soil])) if soil.any() else 0.0, camera_v


def gradient_norm(u: np.ndarray, v: np.ndarray, valid: np.ndarray) -> np.ndarray:
    """Frobenius norm of a displacement's gradient by central differences.

    Parameters
    ----------
    u, v : (H, W) array
        Displacement, px.
    valid : (H, W) bool array
        Where it is known. A derivative whose two neighbours are not both known counts as zero.

    Returns
    -------
    (H, W) array
        px/px.
    """
    total = np.zeros(u.shape, np.float64)
    for component in (u, v):
        for axis in (0, 1):
            total += np.square(_central_difference(component, valid, axis))
    return np.sqrt(total)


def _central_difference(field: np.ndarray, valid: np.ndarray, axis: int) -> np.ndarray:
    derivative = np.zeros(field.shape, np.float64)
    known = np.where(valid, field, 0.0)
    after, before = _shifted(known, axis)
    both_after, both_before = _shifted(valid, axis)
    inner = [slice(None), slice(None)]
    inner[axis] = slice(1, -1)
    derivative[tuple(inner)] = np.where(both_after & both_before, (after - before) / 2, 0.0)
    return derivative


def _shifted(field: np.ndarray, axis: int) -> tuple[np.ndarray, np.ndarray]:
    """Give the next and the former neighbour along `axis` of every pixel that has both."""
    length = field.shape[axis]
    return field.take(range(2, length), axis), field.take(range(length - 2), axis)
