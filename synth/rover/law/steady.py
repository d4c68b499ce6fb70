"""A wheel at a given sinkage in level soil that flows around it: the published integral, no memory."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synth.rover.law.response import SoilError, generic_response
from synth.rover.law.rft import ResistiveSoil

_ELEMENTS = 2000
"""Of the part of the rim that leads; ten times as many change forces by less than 1e-5."""


@dataclass(frozen=True)
class SteadyForces:
    """Of the soil on a wheel, about its axle: N, N, and N m in the sense of its spin."""

    force_x: float
    force_z: float
    torque: float


def steady_forces(
    soil: ResistiveSoil, *, slip: float, sinkage: float, radius: float, width: float
) -> SteadyForces:
    """Integrate the traction of flowing soil over the rim ahead of the axle.

    Parameters
    ----------
    slip : float
        Skid where negative, -1 locked; below 1.
    sinkage, radius, width : float
        m; `sinkage` below `radius`.

    Raises
    ------
    SoilError
        Slip or sinkage is out of range.
    """
    if not -1 <= slip < 1:
        raise SoilError(f"slip = {slip}: -1 to less than 1 is allowed")
    if not 0 < sinkage < radius:
        raise SoilError(f"sinkage = {sinkage} m: above 0 and below the radius, {radius} m, is allowed")
    angle, pitch = _leading(math.acos(1 - sinkage / radius))
    sine, cosine = np.sin(angle), np.cos(angle)
    rim = 1 / (1 - slip) if slip >= 0 else 1 + slip
    velocity_x, velocity_z = 1 - rim * cosine, -rim * sine
    length = np.hypot(velocity_x, velocity_z)
    generic = generic_response(sine, -cosine, velocity_x / length, velocity_z / length)
    level = soil.scale * (sinkage - radius * (1 - cosine)) * width * radius * pitch
    pressure = level * np.maximum(generic.pressure, 0.0)
    limit = soil.surface_friction * pressure
    shear = np.clip(level * generic.shear, -limit, limit)
    force_x, force_z = shear * cosine - pressure * sine, shear * sine + pressure * cosine
    return SteadyForces(float(force_x.sum()), float(force_z.sum()), float(-radius * shear.sum()))


def _leading(entry: float) -> tuple[NDArray, float]:
    """Angles of elements from the lowest point to where the rim enters the soil, rad, and their spacing."""
    pitch = entry / _ELEMENTS
    return (np.arange(_ELEMENTS) + 0.5) * pitch, pitch
