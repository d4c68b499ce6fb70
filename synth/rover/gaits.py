"""How a vehicle moves: what its servos are told, and when a phase begins.

Rolling: all wheels turn alike at a constant rim speed. Inching, or push-rolling (the paper's Fig. 15): while
the side-frames spread, the front wheels roll and the rear ones push; while they close, the other way round.
"The static wheels must actually counter-rotate in synchrony with the expanding or contracting side frame; if
they were to be locked they would rotate in the soil as the side frame moves" (section 4.1): a pushing
wheel's servo turns against its arm.
"""

import math
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from synth.rover.stance import SPREADS, SideFrame, side_frame
from synth.rover.vehicle import Vehicle, VehicleError, VehicleWheel

GAITS = ("rolling", "inching")
ROLL, EXPAND, CONTRACT = "roll", "expand", "contract"
DEFAULT_SPEED = 0.06
"""m/s of the rim of a rolling wheel; Scarab drives at 3 to 6 cm/s."""
_SMOOTHING = 0.5
"""s in which a motion starts and ends: it moves 280 kg."""
_INSTANT = 1e-6
"""s; a clock that adds up time steps is as far off at most, and a phase begins with a whole step."""


class Gait(Protocol):
    """What the servos are told over time.

    Attributes
    ----------
    phases : tuple of str
        In order; they repeat.
    stance : str
        Keyframe to start from.
    speed : float
        Of the rim of a rolling wheel, m/s.
    cycle : float or None
        s; None where nothing repeats.
    """

    phases: tuple[str, ...]
    stance: str
    speed: float
    cycle: float | None

    def command(self, time: float) -> NDArray:
        """Targets of all actuators `time` s after the start, shape (actuator_count,)."""
        ...

    def phase(self, time: float) -> str:
        """Name of the phase at a time, s."""
        ...


class Rolling:
    """All wheels driven alike, the stance held.

    Parameters
    ----------
    vehicle : Vehicle
        Every driven wheel's servo must hold a position or a velocity.
    speed : float
        Of the rim, m/s.
    stance : str, optional
        Keyframe; by default `middle` where there is one, else the first.
    """

    phases = (ROLL,)
    cycle = None

    def __init__(self, vehicle: Vehicle, *, speed: float = DEFAULT_SPEED, stance: str | None = None) -> None:
        require_speed(speed)
        self.stance = _choose_stance(vehicle, stance)
        self._held, self.speed = held_command(vehicle, self.stance), speed
        driven = [wheel for wheel in vehicle.wheels if wheel.actuator >= 0]
        if not driven:
            raise VehicleError(f"{vehicle.path}: no wheel has a servo")
        self._servos = np.array([wheel.actuator for wheel in driven])
        self._radius = np.array([wheel.placed.radius for wheel in driven])
        self._by_position = np.array([_holds_position(vehicle, wheel) for wheel in driven])

    def command(self, time: float) -> NDArray:
        """See `Gait.command`."""
        told = self._held.copy()
        rolled, speed = _started(time, self.speed)
        told[self._servos] += np.where(self._by_position, rolled, speed) / self._radius
        return told

    def phase(self, time: float) -> str:
        """See `Gait.phase`."""
        return ROLL


class Inching:
    """Push-rolling between two wheelbases.

    Parameters
    ----------
    vehicle : Vehicle
        With servos `left_spread`, `right_spread`, and one front and one rear wheel a side on position servos.
    speed : float
        Of the rim of a rolling wheel, and that at which the wheelbase changes, m/s.
    shortest, longest : float
        Wheelbase, m.
    """

    phases = (EXPAND, CONTRACT)
    stance = "high"

    def __init__(
        self,
        vehicle: Vehicle,
        *,
        speed: float = DEFAULT_SPEED,
        shortest: float = 0.8,
        longest: float = 1.3,
    ) -> None:
        require_speed(speed)
        self.frame: SideFrame = side_frame(vehicle)
        for wheelbase in (shortest, longest):
            self.frame.require(wheelbase)
        if not shortest < longest:
            raise VehicleError(f"wheelbase from {shortest:g} to {longest:g} m: the first must be the smaller")
        self._held, self.speed = held_command(vehicle, self.stance), speed
        self._spreads = np.array([vehicle.actuator(name) for name in SPREADS])
        self._front = np.array([wheel.actuator for wheel in vehicle.wheels if not wheel.is_rear])
        self._rear = np.array([wheel.actuator for wheel in vehicle.wheels if wheel.is_rear])
        self._radius = vehicle.wheels[0].placed.radius
        self._shortest, self._stroke = shortest, longest - shortest
        self._half = round(self._stroke / speed + _SMOOTHING, 2)  # whole time steps
        self._smooth = _SMOOTHING / self._half
        self.cycle = 2 * self._half
        self._first = self.frame.spread(shortest)

    def command(self, time: float) -> NDArray:
        """See `Gait.command`."""
        told = self._held.copy()
        cycles, within = divmod(time + _INSTANT, self.cycle)
        opening = self._eased(min(within / self._half, 1.0))
        closing = self._eased(max(within / self._half - 1.0, 0.0))
        spread = self.frame.spread(self._shortest + self._stroke * (opening - closing))
        arm = (spread - self._first) / 2  # the front arm turns by -arm, the rear one by +arm
        rolled = self._stroke / self._radius
        told[self._spreads] = spread
        told[self._front] = (cycles + opening) * rolled + arm
        told[self._rear] = (cycles + closing) * rolled - arm
        return told

    def phase(self, time: float) -> str:
        """See `Gait.phase`."""
        return EXPAND if (time + _INSTANT) % self.cycle < self._half else CONTRACT

    def _eased(self, share: float) -> float:
        """Way done after a share of the time: speed rises, stays and falls linearly."""
        ease = self._smooth
        if share < ease:
            way = share * share / (2 * ease)
        elif share <= 1 - ease:
            way = share - ease / 2
        else:
            way = 1 - ease - (1 - share) ** 2 / (2 * ease)
        return way / (1 - ease)


def make_gait(name: str, vehicle: Vehicle, *, speed: float = DEFAULT_SPEED) -> Rolling | Inching:
    """A gait by its name.

    Raises
    ------
    VehicleError
        There is no such gait, or the vehicle cannot do it.
    """
    if name not in GAITS:
        raise VehicleError(f"gait {name!r}: allowed are {', '.join(GAITS)}")
    return Rolling(vehicle, speed=speed) if name == "rolling" else Inching(vehicle, speed=speed)


def held_command(vehicle: Vehicle, stance: str) -> NDArray:
    """Targets that hold a stance: the keyframe's own."""
    model = vehicle.model
    return model.key_ctrl[model.key(stance).id].copy() if stance else np.zeros(model.nu)


def require_speed(speed: float) -> None:
    """Refuse a speed that is none.

    Raises
    ------
    VehicleError
        It is not positive.
    """
    if not (speed > 0 and math.isfinite(speed)):
        raise VehicleError(f"speed {speed:g} m/s: must be positive")


def _started(time: float, speed: float) -> tuple[float, float]:
    """Way rolled (m) and speed (m/s) of a wheel that starts gently."""
    if time < _SMOOTHING:
        return speed * time * time / (2 * _SMOOTHING), speed * time / _SMOOTHING
    return speed * (time - _SMOOTHING / 2), speed


def _choose_stance(vehicle: Vehicle, stance: str | None) -> str:
    known = vehicle.keyframes
    if stance is not None and stance not in known:
        raise VehicleError(f"{vehicle.path}: stance {stance!r}: it has {', '.join(known) or 'none'}")
    if stance is not None:
        return stance
    return "middle" if "middle" in known else (known[0] if known else "")


def _holds_position(vehicle: Vehicle, wheel: VehicleWheel) -> bool:
    """A servo with stiffness against one with damping only."""
    bias = vehicle.model.actuator_biasprm[wheel.actuator]
    if bias[1] == 0 and bias[2] == 0:
        raise VehicleError(
            f"{vehicle.path}: wheel {wheel.name!r}: its actuator is no position or velocity servo"
        )
    return bool(bias[1] != 0)
