"""Direction of soil motion where motion is significant, and nowhere else (section 2.2, Fig. 4)."""

from typing import TYPE_CHECKING

import numpy as np

from soft.pair_motion import motion_of_pair
from soft.velocity import to_polar, to_velocity

if TYPE_CHECKING:
    import xarray


def significant_direction(displacement: np.ndarray, moving: np.ndarray) -> np.ndarray:
    """Direction of motion inside the moving region.

    Where speed is near zero, direction is that of the error.

    Parameters
    ----------
    displacement : (H, W, 2) array
        Inertial (u, v) in px, x right and y down; NaN where not measured.
    moving : (H, W) bool
        Where motion is significant, as of `moving_mask`.

    Returns
    -------
    (H, W) float32
        In radians, -pi to pi, counter-clockwise from right, pi/2 is up; NaN outside the region, where nothing
        was measured and where the vector is zero.

    Raises
    ------
    ValueError
        If shapes differ.
    """
    if displacement.shape != (*moving.shape, 2):
        raise ValueError(f"moving: shape {moving.shape}: must be {displacement.shape[:2]}")
    _, direction = to_polar(*to_velocity(displacement, metres_per_pixel=1.0, time_step=1.0))
    return np.where(moving, direction, np.nan).astype(np.float32)


def direction_of(flow: "xarray.Dataset", *, pair: int = 0) -> np.ndarray:
    """Direction within the moving region of one pair of a SoilFlow: (H, W) float32 in radians."""
    motion = motion_of_pair(flow, pair)
    return significant_direction(motion.displacement, motion.moving)
