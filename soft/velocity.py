"""Displacement per frame to velocity, Cartesian and polar (section 2.2)."""

import numpy as np


def to_velocity(
    displacement: np.ndarray, *, metres_per_pixel: float, time_step: float
) -> tuple[np.ndarray, np.ndarray]:
    """Velocity in the world frame from displacement in the picture.

    Parameters
    ----------
    displacement : (..., 2) array
        (u, v) px in one time step, x right and y down.
    metres_per_pixel : float
        Pixel size in m.
    time_step : float
        Time between the two pictures in s.

    Returns
    -------
    velocity_x, velocity_z : (...) array
        In m/s, x right and z **up**: here, and nowhere else in this package, y is flipped.
    """
    scale = np.float32(metres_per_pixel / time_step)
    return displacement[..., 0] * scale, displacement[..., 1] * -scale


def to_polar(x: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Magnitude and direction of vectors whose second component points up.

    Returns
    -------
    magnitude : array
        In the unit of the components.
    direction : array
        In radians, -pi to pi, counter-clockwise from x; pi/2 is up. NaN where the vector is zero or NaN.
    """
    magnitude = np.hypot(x, z)
    direction = np.arctan2(z, x)
    return magnitude, np.where(magnitude > 0, direction, np.asarray(np.nan, direction.dtype))
