"""Bekker-Wong-Janosi with memory: pressure by plastic sinkage of the ground, shear by displacement since contact."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synth.rover.law.interface import PlacedWheel, WheelForces, WheelStates

_CELL = 0.004  # m
_BEHIND, _AHEAD = 3.0, 30.0  # m


@dataclass(frozen=True)
class BekkerSoil:
    """Dry sand; Wong, *Theory of Ground Vehicles*, table of pressure-sinkage and shear values.

    Attributes
    ----------
    modulus : float
        k_c / b + k_phi at the wheel's width, N/m^(n + 2).
    exponent : float
    cohesion : float
        Pa.
    friction_angle : float
        rad.
    shear_displacement : float
        Janosi's K, m.
    unloading : float
        Pa a metre, of soil that was pressed before; assumed.
    """

    modulus: float = 1.53e6
    exponent: float = 1.1
    cohesion: float = 1.04e3
    friction_angle: float = float(np.radians(28.0))
    shear_displacement: float = 0.01
    unloading: float = 5e6


class BekkerLaw:
    """The law, for all wheels at once: rim elements times wheels.

    Parameters
    ----------
    soil : BekkerSoil, optional
    element_count : int, optional
        Round the rim.
    """

    def __init__(self, soil: BekkerSoil | None = None, *, element_count: int = 180) -> None:
        self.soil = soil or BekkerSoil()
        self._around = 2 * np.pi * np.arange(element_count) / element_count

    def place(self, wheels: Sequence[PlacedWheel]) -> None:
        """See `WheelSoilLaw.place`."""
        self._wheels = tuple(wheels)
        self._radius = np.array([wheel.radius for wheel in wheels])[:, None]
        self._width = np.array([wheel.width for wheel in wheels])[:, None]
        self._tracks = sorted({wheel.track for wheel in wheels})
        self._row = np.array([self._tracks.index(wheel.track) for wheel in wheels])[:, None]
        self.reset()

    def reset(self) -> None:
        """See `WheelSoilLaw.reset`."""
        self._ground = np.zeros((len(self._tracks), int((_BEHIND + _AHEAD) / _CELL)))
        self._slipped = np.zeros((len(self._wheels), self._around.size))

    def rut(self, track: str) -> NDArray:
        """See `WheelSoilLaw.rut`."""
        depth = self._ground[self._tracks.index(track)]
        return np.stack([np.arange(depth.size) * _CELL - _BEHIND, -depth], axis=1)

    def advance(self, states: WheelStates, time_step: float) -> WheelForces:
        """See `WheelSoilLaw.advance`."""
        angle = self._around + states.angle[:, None]
        sine, cosine = np.sin(angle), np.cos(angle)  # an element at angle 0 is at the top
        x, z = states.x[:, None] + self._radius * sine, states.z[:, None] + self._radius * cosine
        cell = np.clip(((x + _BEHIND) / _CELL).astype(int), 0, self._ground.shape[1] - 1)
        pressure = self._press(-z, cell) * (cosine < 0)
        # Velocity of the element along the rim, in the sense of the spin.
        slide = (
            states.velocity_x[:, None] * cosine
            - states.velocity_z[:, None] * sine
            + self._radius * states.spin[:, None]
        )
        shear = self._shear(pressure, slide * time_step)
        area = self._width * self._radius * (self._around[1] - self._around[0])
        force_x = (-pressure * sine - shear * cosine) * area
        force_z = (-pressure * cosine + shear * sine) * area
        torque = -shear * area * self._radius
        return WheelForces(force_x.sum(axis=1), force_z.sum(axis=1), torque.sum(axis=1))

    def _press(self, depth: NDArray, cell: NDArray) -> NDArray:
        """Pressure at `depth`; the ground yields where it would be more than virgin soil bears."""
        soil = self.soil
        virgin = soil.modulus * np.maximum(depth, 0.0) ** soil.exponent
        elastic = soil.unloading * np.maximum(depth - self._ground[self._row, cell], 0.0)
        yields = (elastic > virgin) & (depth > 0)
        rows = np.broadcast_to(self._row, depth.shape)
        left = (depth - virgin / soil.unloading)[yields]
        np.maximum.at(self._ground, (rows[yields], cell[yields]), left)
        return np.minimum(elastic, virgin)

    def _shear(self, pressure: NDArray, slid: NDArray) -> NDArray:
        soil, touches = self.soil, pressure > 0
        self._slipped = np.where(touches, self._slipped + slid, 0.0)
        most = soil.cohesion * touches + pressure * np.tan(soil.friction_angle)
        share = -np.expm1(-np.abs(self._slipped) / soil.shear_displacement)
        return most * share * np.sign(self._slipped)
