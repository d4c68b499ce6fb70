"""Laws of pressure and sinkage, for comparison: Bekker-Wong-Janosi, and the same on vertical columns (SCM).

Bekker's pressure k z^n under a rim (M. G. Bekker, *Introduction to Terrain-Vehicle Systems*, 1969) and
Janosi's shear (Z. Janosi, B. Hanamoto, 1961; J. Y. Wong, *Theory of Ground Vehicles*). The soil contact
model SCM (Krenn, Hirzinger, 2008) lets the same pressure act vertically on columns of soil, and the same
shear horizontally. Both get what they need to serve a vehicle that stands, reverses and follows in ruts:
pressure that goes back elastically, shear displacement that every element of the rim carries along, and the
tracks of `synth.rover.law.ground`.
"""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from synth.rover.law.response import SoilError
from synth.rover.law.rim import carried
from synth.rover.law.rim_law import RimLaw
from synth.rover.law.touch import Touch


@dataclass(frozen=True)
class BekkerSoil:
    """Bekker's and Janosi's constants.

    Attributes
    ----------
    modulus : float
        k = kc / b + kphi in pressure = k sinkage^n, Pa/m^n.
    exponent : float
        n.
    cohesion : float
        Pa.
    friction : float
        Tangent of the angle of internal friction.
    shear_modulus : float
        Janosi's K, m.
    stiffness : float
        Of pressure that goes back, Pa/m.
    """

    modulus: float
    exponent: float
    friction: float
    shear_modulus: float
    stiffness: float
    cohesion: float = 0.0

    @property
    def rut_share(self) -> float:
        """Soil does not come back: Bekker's wheel leaves a rut as deep as it sank."""
        return 1.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (value > 0 or (field.name == "cohesion" and value == 0)):
                raise SoilError(f"{field.name} = {value}: above 0 is allowed")


class BekkerLaw(RimLaw[BekkerSoil]):
    """Pressure normal to the rim, shear along it."""

    _remembered = (*RimLaw._remembered, "_mobilized")

    def reset(self) -> None:
        """Forget ruts, pressure and how far the soil was sheared."""
        super().reset()
        self._mobilized = np.zeros_like(self.pressure)

    def _carry(self, moved: NDArray) -> None:
        super()._carry(moved)
        self._mobilized = carried(self._mobilized, moved)

    def _step(self, touch: Touch, time_step: float) -> float:
        soil = self.soil
        bearing = soil.modulus * touch.depth**soil.exponent
        elastic = np.maximum(self.pressure + soil.stiffness * time_step * touch.into, 0.0)
        self.pressure = np.minimum(elastic, bearing)
        # Janosi's 1 - exp(-j / K) in steps of j, so that what slides back has to be sheared anew.
        sheared = -np.expm1(-np.abs(touch.along) * time_step / soil.shear_modulus)
        self._mobilized = self._mobilized + sheared * (-np.sign(touch.along) - self._mobilized)
        self._mobilized *= self.pressure > 0
        self.shear = self._mobilized * (soil.cohesion + soil.friction * self.pressure)
        return 0.0


class ColumnLaw(BekkerLaw):
    """The same pressure vertically on columns, the same shear horizontally, after SCM."""

    def _directions(self, touch: Touch) -> tuple[NDArray, NDArray, NDArray]:
        zero = np.zeros_like(touch.sine)
        return zero, zero + 1.0, self._rims.area * touch.cosine

    def _torque(self, touch: Touch, force_x: NDArray, force_z: NDArray) -> NDArray:
        return -(self._rims.radius * (touch.sine * force_z + touch.cosine * force_x)).sum(axis=1)
