"""What a vehicle and a wheel-soil law tell each other.

World frame, SI units: x forward along the travel, z up, the undisturbed surface of the soil at z = 0. Every
wheel turns in a plane y = constant. All wheels go through one call, so that a law can work on all of them at
once.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from numpy.typing import NDArray


@dataclass(frozen=True)
class PlacedWheel:
    """A wheel as a law is told of it (m); wheels of one track, such as `left`, share a rut."""

    name: str
    track: str
    radius: float
    width: float


@dataclass(frozen=True)
class WheelStates:
    """Of every placed wheel, in the order of placing, each array of shape (wheel_count,), float64.

    `x`, `z` are the axle's place (m), `velocity_x`, `velocity_z` its velocity (m/s), `angle` (rad) and
    `spin` (rad/s) the turn of the rim in the world: `spin` > 0 drives the wheel towards +x (its top moves
    towards +x).
    """

    x: NDArray
    z: NDArray
    velocity_x: NDArray
    velocity_z: NDArray
    angle: NDArray
    spin: NDArray


@dataclass(frozen=True)
class WheelForces:
    """Of the soil on every wheel, about its axle, shape (wheel_count,): N, N, and N m in the sense of `spin`.

    A wheel that drives meets a `torque` < 0.
    """

    force_x: NDArray
    force_z: NDArray
    torque: NDArray


@runtime_checkable
class Continuable(Protocol):
    """What can be left and gone on with from its state."""

    def state(self) -> dict[str, NDArray]:
        """All that is remembered, as arrays by name."""
        ...

    def restore(self, state: Mapping[str, NDArray]) -> None:
        """Go on from what `state` gave."""
        ...


class WheelSoilLaw(Protocol):
    """The force of the soil on wheels, with what the soil and the rim remember."""

    def place(self, wheels: Sequence[PlacedWheel]) -> None:
        """Take the wheels of one vehicle on undisturbed soil; others are forgotten."""
        ...

    def advance(self, states: WheelStates, time_step: float) -> WheelForces:
        """Force at `states`, `time_step` (s) after the last call; the first call starts from rest.

        Called once every step of the vehicle (1 ms), it steps hysteresis and rut memory.
        """
        ...

    def reset(self) -> None:
        """Forget ruts and hysteresis; the wheels stay placed."""
        ...

    def rut(self, track: str) -> NDArray:
        """Surface of the soil along a track, shape (point_count, 2): x and z, m; for pictures."""
        ...
