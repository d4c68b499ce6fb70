"""Who pushes and who resists: forces on the wheels and how far they went, averaged over a phase of a gait."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from synth.rover.law.interface import PlacedWheel
from synth.rover.ride import Ride


@dataclass(frozen=True)
class WheelMean:
    """A wheel over one phase.

    Attributes
    ----------
    wheel : str
    force_x, force_z : float
        Mean force of the soil, N; `force_x` > 0 is thrust, < 0 resistance.
    torque : float
        Of the soil about the axle, N m; < 0 where the wheel drives.
    advance : float
        How far the axle moved, m.
    rolled : float
        How far the rim turned, m.
    sinkage : float
        Mean depth of the rim's lowest point below the undisturbed surface, m.
    """

    wheel: str
    force_x: float
    force_z: float
    torque: float
    advance: float
    rolled: float
    sinkage: float


@dataclass(frozen=True)
class PhaseMean:
    """All wheels over one phase of a gait.

    Attributes
    ----------
    phase : str
    duration : float
        s.
    wheels : tuple of WheelMean
    """

    phase: str
    duration: float
    wheels: tuple[WheelMean, ...]

    @property
    def pull(self) -> float:
        """Sum of the horizontal forces, N: what is left for the cable."""
        return sum(wheel.force_x for wheel in self.wheels)

    def to_dict(self) -> dict:
        """As JSON holds it."""
        return asdict(self)

    @staticmethod
    def from_dict(told: dict) -> "PhaseMean":
        """From what `to_dict` gave."""
        return PhaseMean(
            told["phase"], told["duration"], tuple(WheelMean(**wheel) for wheel in told["wheels"])
        )


class Balance:
    """Adds up a ride, phase by phase.

    Parameters
    ----------
    ride : Ride

    Attributes
    ----------
    wheels : tuple of PlacedWheel
    time_step : float
        s.
    sums : dict of ndarray, shape (6, wheel_count)
        For each phase: force_x, force_z, torque, what the axle advanced, the rim turned, the axle's height.
    steps : dict of int
        For each phase.
    """

    def __init__(self, ride: Ride) -> None:
        self._ride = ride
        self.wheels = tuple(wheel.placed for wheel in ride.vehicle.wheels)
        self.time_step = ride.time_step
        self.sums: dict[str, NDArray] = {}
        self.steps: dict[str, int] = {}
        self._place = self._placed()

    def add(self, phase: str) -> None:
        """Count the step that the ride has just done."""
        forces, now = self._ride.forces, self._placed()
        one = np.concatenate(
            [[forces.force_x, forces.force_z, forces.torque], (now - self._place)[:2], now[2:]]
        )
        self._place = now
        self.sums[phase] = one + self.sums.get(phase, 0.0)
        self.steps[phase] = self.steps.get(phase, 0) + 1

    def means(self) -> tuple[PhaseMean, ...]:
        """One for each phase, in the order of their first step."""
        return means_over([self])

    def _placed(self) -> NDArray:
        """Axles' x (m), rims' angle (rad) and axles' z (m), shape (3, wheel_count)."""
        states = self._ride.states
        return np.stack([states.x, states.angle, states.z])


def means_over(balances: Sequence[Balance]) -> tuple[PhaseMean, ...]:
    """Means over several stretches of one ride, one for each phase in the order of their first step."""
    phases = dict.fromkeys(phase for balance in balances for phase in balance.sums)
    return tuple(_phase_mean(phase, balances) for phase in phases)


def _phase_mean(phase: str, balances: Sequence[Balance]) -> PhaseMean:
    with_it = [balance for balance in balances if phase in balance.sums]
    steps = sum(balance.steps[phase] for balance in with_it)
    sums = np.sum([balance.sums[phase] for balance in with_it], axis=0)
    wheels = tuple(
        _wheel_mean(placed, column, steps) for placed, column in zip(with_it[0].wheels, sums.T, strict=True)
    )
    return PhaseMean(phase, steps * with_it[0].time_step, wheels)


def _wheel_mean(placed: PlacedWheel, sums: NDArray, steps: int) -> WheelMean:
    force_x, force_z, torque, advance, turned, height = (float(one) for one in sums)
    return WheelMean(
        wheel=placed.name,
        force_x=force_x / steps,
        force_z=force_z / steps,
        torque=torque / steps,
        advance=advance,
        rolled=turned * placed.radius,
        sinkage=placed.radius - height / steps,
    )
