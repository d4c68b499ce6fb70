"""What laws that work on elements of a rim share: the ground, the rim as it is, and the sum over elements."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import ClassVar, Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from synth.rover.law.ground import Tracks
from synth.rover.law.interface import PlacedWheel, WheelForces, WheelStates
from synth.rover.law.response import SoilError
from synth.rover.law.rim import RimElements, Rims, carried
from synth.rover.law.touch import Touch

ELEMENTS = 64
"""Of the lower 160 degrees of a rim."""
_COLUMNS_A_RADIUS = 100
"""Columns of soil along the smallest wheel's radius."""
_RELAXATION = 0.15
"""Share of what an elastic rim is off its rest by that it moves in a step, at most."""


class RimSoil(Protocol):
    """What every law has to know of a soil: see `ResistiveSoil`, `BekkerSoil`."""

    @property
    def stiffness(self) -> float:
        """Of pressure that is elastic, Pa/m."""
        ...

    @property
    def rut_share(self) -> float:
        """Depth of the rut behind a wheel / depth of the wheel below the surface before."""
        ...


Soil = TypeVar("Soil", bound=RimSoil)


class RimLaw(ABC, Generic[Soil]):
    """All wheels at once; rims are rigid or elastic.

    An elastic rim is a row of radial springs on the hub (Winkler's foundation): an element gives way by
    pressure / `rim_stiffness`, and the rim's slope follows. That is what flattens a pneumatic wheel.

    Parameters
    ----------
    soil : RimSoil
    rim_stiffness : float, optional
        Of a pneumatic wheel, pressure / deflection, Pa/m; default: rigid.
    element_count : int
        Of the lower 160 degrees of each rim.

    Attributes
    ----------
    soil : RimSoil
    pressure, shear : ndarray, shape (wheel_count, element_count)
        Of the soil on the elements, Pa: against the outward normal, and along the tangent.
    """

    _remembered: ClassVar[tuple[str, ...]] = ("pressure", "shear", "_deflection", "_deflecting")
    """Arrays over the elements, of a law's own, that `state` gives."""

    def __init__(
        self, soil: Soil, *, rim_stiffness: float | None = None, element_count: int = ELEMENTS
    ) -> None:
        if rim_stiffness is not None and not rim_stiffness > 0:
            raise SoilError(f"rim_stiffness = {rim_stiffness}: above 0 Pa/m, or none at all, is allowed")
        self.soil, self._rim_stiffness, self._element_count = soil, rim_stiffness, element_count
        stiffness_ratio = 0.0 if rim_stiffness is None else rim_stiffness / soil.stiffness
        self._relaxation = min(_RELAXATION, 0.5 * stiffness_ratio)
        self._wheels: tuple[PlacedWheel, ...] = ()

    def place(self, wheels: Sequence[PlacedWheel]) -> None:
        """Take wheels on undisturbed soil."""
        if not wheels:
            raise SoilError("wheels: at least one is needed")
        self._wheels = tuple(wheels)
        self._track_names = list(dict.fromkeys(wheel.track for wheel in wheels))
        self.reset()

    def reset(self) -> None:
        """Forget ruts and tractions."""
        self._rims = Rims(self._wheels, self._element_count)
        self._tracks = Tracks(
            [self._track_names.index(wheel.track) for wheel in self._wheels],
            spacing=float(self._rims.radius.min()) / _COLUMNS_A_RADIUS,
            share=self.soil.rut_share,
        )
        shape = (len(self._wheels), self._element_count)
        self.pressure, self.shear = np.zeros(shape), np.zeros(shape)
        self._deflection, self._deflecting = np.zeros(shape), np.zeros(shape)

    def rut(self, track: str) -> NDArray:
        """Surface along a track, shape (n, 2): x and z, m."""
        return self._tracks.profile(self._track_names.index(track))

    def state(self) -> dict[str, NDArray]:
        """All that soil and rims remember, as arrays by name; `restore` goes on from it."""
        tracks = {f"tracks_{name}": value for name, value in self._tracks.state().items()}
        kept = {name: getattr(self, name).copy() for name in self._remembered}
        return {"turns": self._rims.turns.copy()} | tracks | kept

    def restore(self, state: Mapping[str, NDArray]) -> None:
        """Go on from what `state` gave, with the wheels that were placed then."""
        self._rims.turns = state["turns"]
        prefix = "tracks_"
        self._tracks.restore({k[len(prefix) :]: v for k, v in state.items() if k.startswith(prefix)})
        for name in self._remembered:
            setattr(self, name, state[name].copy())

    def advance(self, states: WheelStates, time_step: float) -> WheelForces:
        """Forces at `states`, `time_step` (s) after the last call."""
        rim = self._rims.at(states.angle)
        if rim.moved.any():
            self._carry(rim.moved)
        touch = self._touch(rim, states)
        viscous = self._step(touch, time_step)
        if self._rim_stiffness is not None:
            self._deflect(self._rim_stiffness, time_step)
        return self._summed(touch, np.maximum(self.pressure + viscous, 0.0))

    @abstractmethod
    def _step(self, touch: Touch, time_step: float) -> NDArray | float:
        """Step `pressure` and `shear`; give the pressure that acts besides, Pa."""

    def _carry(self, moved: NDArray) -> None:
        """Let what elements keep follow the rims, which turned on by whole elements."""
        self.pressure, self.shear = carried(self.pressure, moved), carried(self.shear, moved)

    def _directions(self, touch: Touch) -> tuple[NDArray, NDArray, NDArray]:
        """Sine and cosine of what pressure acts along, from the vertical, and the area it acts on, m2."""
        return touch.sine, touch.cosine, self._rims.area

    def _touch(self, rim: RimElements, states: WheelStates) -> Touch:
        radius = self._rims.radius
        sine, cosine, reach = rim.sine, rim.cosine, radius
        self._tracks.follow(states.x, states.z - radius[:, 0] + self._deflection.max(axis=1))
        if self._rim_stiffness is not None:
            reach = radius - self._deflection
            slope = _slope(self._deflection, self._rims.pitch) / reach
            length = np.sqrt(1 + slope * slope)
            sine, cosine = (sine + slope * cosine) / length, (cosine - slope * sine) / length
        x = states.x[:, None] + reach * rim.sine
        depth = self._tracks.height(x) - states.z[:, None] + reach * rim.cosine
        velocity_x, velocity_z = states.velocity_x[:, None], states.velocity_z[:, None]
        into = velocity_x * sine - velocity_z * cosine
        if self._rim_stiffness is not None:
            into -= self._deflecting
        along = velocity_x * cosine + velocity_z * sine - radius * states.spin[:, None]
        return Touch(sine, cosine, np.maximum(depth, 0.0), into, along, x)

    def _deflect(self, stiffness: float, time_step: float) -> None:
        pressed = 0.5 * self.pressure
        pressed[:, 1:] += 0.25 * self.pressure[:, :-1]
        pressed[:, :-1] += 0.25 * self.pressure[:, 1:]
        by = self._relaxation * (pressed / stiffness - self._deflection)
        self._deflection = self._deflection + by
        self._deflecting = by / time_step

    def _summed(self, touch: Touch, pressure: NDArray) -> WheelForces:
        sine, cosine, area = self._directions(touch)
        force_x = (self.shear * cosine - pressure * sine) * area
        force_z = (self.shear * sine + pressure * cosine) * area
        return WheelForces(force_x.sum(axis=1), force_z.sum(axis=1), self._torque(touch, force_x, force_z))

    def _torque(self, touch: Touch, force_x: NDArray, force_z: NDArray) -> NDArray:
        """Of the shear alone: pressure does no work on an element as the rim turns under it."""
        return -(self._rims.radius * self._rims.area * self.shear).sum(axis=1)


def _slope(values: NDArray, spacing: float) -> NDArray:
    """Derivative along the rows as `numpy.gradient` has it, which takes ten times as long."""
    slope = np.empty_like(values)
    slope[:, 1:-1] = (values[:, 2:] - values[:, :-2]) * (0.5 / spacing)
    slope[:, 0] = (values[:, 1] - values[:, 0]) / spacing
    slope[:, -1] = (values[:, -1] - values[:, -2]) / spacing
    return slope
