"""Resistive force theory with memory: elastic until the grains flow, ruts where wheels have been.

Each element of the rim holds the traction of the soil on it. Motion changes it elastically; where it would
do more work than flowing soil can take (`synth.rover.law.response`), the surplus is flow, and with flow the
traction goes over to that of steady flow. Splitting motion into an elastic and a flowing part is the idea of
elastic resistive force theory (Yilmaz, Douglas, Perron, Kamrin, *Soft Matter*, 2026, DOI
10.1039/D6SM00040A); its equations were not at hand, these are this project's own. An element that leaves the
soil gives its pressure back elastically, and slides on it by friction.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, with_config

from synth.rover.law.response import SoilError, generic_response
from synth.rover.law.rim import carried
from synth.rover.law.rim_law import RimLaw
from synth.rover.law.touch import Touch

_LEASH = 0.005
"""Way over which the direction of flow turns / radius; assumed."""
_LEAST_LENGTH = 1e-15
"""m; what moved by less has no direction."""
_LEAST_TRACTION = 1e-9
"""Pa."""


@with_config(ConfigDict(extra="forbid", allow_inf_nan=False))
@dataclass(frozen=True)
class ResistiveSoil:
    """What the law has to know of a soil.

    Attributes
    ----------
    scale : float
        Traction of flowing soil / (depth x generic traction), Pa/m: `published_scale`, or identified.
    surface_friction : float
        Between rim and soil.
    stiffness : float
        Traction / displacement before the soil flows, Pa/m.
    shear_share : float
        Stiffness along the surface / `stiffness`.
    rut_share : float
        Depth of the rut behind a wheel / depth of the wheel below the surface before.
    hardening : float
        Scale where a wheel has passed / scale of fresh soil.
    damping_time : float
        Viscous / elastic stiffness, s; acts on elastic motion alone, so that a vehicle does not ring.
    """

    scale: float
    surface_friction: float
    stiffness: float
    shear_share: float = 1.0
    rut_share: float = 1.0
    hardening: float = 1.0
    damping_time: float = 2e-3

    def __post_init__(self) -> None:
        for name in ("scale", "surface_friction", "stiffness", "shear_share", "hardening"):
            if not getattr(self, name) > 0:
                raise SoilError(f"{name} = {getattr(self, name)}: above 0 is allowed")
        if not 0 <= self.rut_share <= 1:
            raise SoilError(f"rut_share = {self.rut_share}: 0 to 1 is allowed")
        if not self.damping_time >= 0:
            raise SoilError(f"damping_time = {self.damping_time}: 0 s or more is allowed")


@dataclass(frozen=True)
class Flow:
    """Traction that flowing soil puts on elements moving as they do, Pa, and the motion's direction.

    `into` and `along` are the direction's components, against the soil and along the tangent.
    """

    pressure: NDArray
    shear: NDArray
    into: NDArray
    along: NDArray


class ResistiveForceLaw(RimLaw[ResistiveSoil]):
    """Resistive force theory as the yield surface of elastic elements."""

    _remembered = (*RimLaw._remembered, "_into", "_along")

    def reset(self) -> None:
        """Forget ruts, tractions and which way the soil flowed."""
        super().reset()
        self._into, self._along = np.zeros_like(self.pressure), np.zeros_like(self.pressure)

    def _carry(self, moved: NDArray) -> None:
        super()._carry(moved)
        self._into, self._along = carried(self._into, moved), carried(self._along, moved)

    def _step(self, touch: Touch, time_step: float) -> NDArray:
        soil = self.soil
        into, along = touch.into * time_step, touch.along * time_step
        flow = self._flow(touch, *self._direction(touch, into, along))
        pressure = np.maximum(self.pressure + soil.stiffness * into, 0.0)
        shear = self.shear - soil.stiffness * soil.shear_share * along
        # What the elastic traction would do beyond what flowing soil takes is flow.
        excess = np.maximum((pressure - flow.pressure) * flow.into - (shear - flow.shear) * flow.along, 0.0)
        excess *= flow.into > 0
        resists = flow.into * flow.into + soil.shear_share * flow.along * flow.along + _LEAST_TRACTION
        given = excess / resists
        pressure -= given * flow.into
        shear += given * soil.shear_share * flow.along
        # Within a displacement of traction / stiffness, flow leads to the traction of steady flow.
        steady = np.sqrt(flow.pressure * flow.pressure + flow.shear * flow.shear) + _LEAST_TRACTION
        reached = -np.expm1(-excess / steady)
        pressure += reached * (flow.pressure - pressure)
        shear += reached * (flow.shear - shear)
        self.pressure = np.maximum(pressure, 0.0) * (touch.depth > 0)
        self.shear = self._rubbed(shear, self.pressure)
        return soil.damping_time * soil.stiffness * touch.into * (excess == 0) * (self.pressure > 0)

    def _direction(self, touch: Touch, into: NDArray, along: NDArray) -> tuple[NDArray, NDArray]:
        """Direction in which soil flows around elements: that from a point they drag behind on a leash.

        What goes to and fro by less than the leash does not turn it.

        Parameters
        ----------
        into, along : ndarray
            Moved since the last call, m.
        """
        in_soil, leash = touch.depth > 0, _LEASH * self._rims.radius
        into, along = (self._into + into) * in_soil, (self._along + along) * in_soil
        length = np.sqrt(into * into + along * along) + _LEAST_LENGTH
        kept = np.minimum(leash / length, 1.0)
        self._into, self._along = kept * into, kept * along
        return into / length, along / length

    def _flow(self, touch: Touch, into: NDArray, along: NDArray) -> Flow:
        """Of soil around elements that move in given directions."""
        sine, cosine = touch.sine, touch.cosine
        velocity_x, velocity_z = into * sine + along * cosine, along * sine - into * cosine
        generic = generic_response(sine, -cosine, velocity_x, velocity_z)
        level = self._scale(touch) * touch.depth
        pressure = level * np.maximum(generic.pressure, 0.0)
        return Flow(pressure, self._rubbed(level * generic.shear, pressure), into, along)

    def _scale(self, touch: Touch) -> NDArray | float:
        if self.soil.hardening == 1:
            return self.soil.scale
        return self.soil.scale * np.where(self._tracks.passes(touch.x) > 0, self.soil.hardening, 1.0)

    def _rubbed(self, shear: NDArray, pressure: NDArray) -> NDArray:
        """Shear, held to surface friction."""
        limit = self.soil.surface_friction * pressure
        return np.minimum(np.maximum(shear, -limit), limit)
