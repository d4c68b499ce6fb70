"""The drawbar pull test: a vehicle drives along fresh soil while a cable holds it back, harder and harder."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synth.rover.balance import Balance, PhaseMean, means_over
from synth.rover.gaits import Inching, Rolling
from synth.rover.law.interface import WheelSoilLaw
from synth.rover.ride import Ride
from synth.rover.travel_reduction import travel_reduction, velocities
from synth.rover.vehicle import Vehicle

ROLLING_STEP = 0.5
"""m of travel at one load ("increased approximately every 0.5 m", the paper's Fig. 17)."""
CYCLES = 2
"""At one load ("held constant for at least two inching cycles", Fig. 17); the last is measured."""
_SAMPLING = 1.0  # s, of the total station; a rover that is soon through with a step is looked at more often
_LONGEST = 3.0  # times what a step takes without travel reduction
_FEWEST_SAMPLES = 6
_SETTLED_OVER = 4  # samples whose mean velocity is compared with that of as many before
_SETTLED_TO = 0.01  # of the rim's speed
STUCK = 0.95
"""Travel reduction at which steps of the load end: from there on a rover digs in where it is."""
_SETTLING = 2.0  # s at rest before it starts
_TENSIONING = 0.5  # s in which the cable's tension rises to the next load
_PULLED_BACK = 0.25  # m at one load, after which it is over


@dataclass(frozen=True)
class LoadSteps:
    """Which loads a test goes through, as drawbar pull over vehicle weight.

    Attributes
    ----------
    loads : tuple of float
        Rising, without the 0 that every test begins with. Empty: steps of `coarse`, a half of that where
        the last one took more than 3 % of travel, a quarter where more than 10 %, until the vehicle is
        stuck (`STUCK`).
    coarse : float
    """

    loads: tuple[float, ...] = ()
    coarse: float = 0.012

    def __post_init__(self) -> None:
        if any(load <= 0 for load in self.loads) or list(self.loads) != sorted(set(self.loads)):
            raise ValueError(f"loads {self.loads}: drawbar pull over vehicle weight, positive and rising")
        if not self.coarse > 0:
            raise ValueError(f"step of the load {self.coarse}: must be positive")

    def following(self, points: Sequence["DrawbarPoint"]) -> float | None:
        """The load after these points; None after the last."""
        if self.loads:
            return self.loads[len(points) - 1] if len(points) <= len(self.loads) else None
        last = points[-1]
        if last.travel_reduction >= STUCK:
            return None
        took = last.travel_reduction - points[-2].travel_reduction if len(points) > 1 else 0.0
        part = 1 if took < 0.03 else 2 if took < 0.1 else 4
        return last.drawbar_pull_ratio + self.coarse / part


@dataclass(frozen=True)
class DrawbarPoint:
    """What was measured at one load.

    Attributes
    ----------
    drawbar_pull_ratio : float
        Tension of the cable over the vehicle's weight.
    velocity : float
        m/s, over whole cycles where there are such.
    travel_reduction : float
        Eq. 8, as a ratio.
    phases : tuple of PhaseMean
        Forces on the wheels while it was measured.
    """

    drawbar_pull_ratio: float
    velocity: float
    travel_reduction: float
    phases: tuple[PhaseMean, ...]

    def to_dict(self) -> dict:
        """As JSON holds it."""
        return {
            "drawbar_pull_ratio": self.drawbar_pull_ratio,
            "velocity": self.velocity,
            "travel_reduction": self.travel_reduction,
            "phases": [phase.to_dict() for phase in self.phases],
        }

    @staticmethod
    def from_dict(told: dict) -> "DrawbarPoint":
        """From what `to_dict` gave."""
        phases = tuple(PhaseMean.from_dict(phase) for phase in told["phases"])
        return DrawbarPoint(told["drawbar_pull_ratio"], told["velocity"], told["travel_reduction"], phases)


@dataclass(frozen=True)
class _Measured:
    velocity: float
    phases: tuple[PhaseMean, ...]


class DrawbarTest:
    """A vehicle under test.

    Parameters
    ----------
    vehicle : Vehicle
    law : WheelSoilLaw
    gait : Rolling or Inching
    time_step : float, optional
        s; the model's own by default.
    cycles : int
        At one load; the last is measured.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        law: WheelSoilLaw,
        gait: Rolling | Inching,
        *,
        time_step: float | None = None,
        cycles: int = CYCLES,
    ) -> None:
        self.gait, self._cycles = gait, cycles
        self.ride = Ride(vehicle, law, stance=gait.stance, time_step=time_step)
        self._settle()
        self._started = self.ride.time

    def points(self, steps: LoadSteps, *, done: Sequence[DrawbarPoint] = ()) -> Iterator[DrawbarPoint]:
        """Measure load after load, the first without any, as `steps` has them.

        None follows a travel reduction of 1 or more.

        Parameters
        ----------
        done : sequence of DrawbarPoint
            Measured already, by a test whose state was restored.
        """
        points = list(done)
        if not points:
            self._measure()  # the first way leads over undisturbed soil for all wheels
            free = self._measure()
            points.append(self._point(0.0, free, free.velocity))
            yield points[0]
        while points[-1].travel_reduction < 1 and (load := steps.following(points)) is not None:
            self._tension(load * self.ride.vehicle.weight)
            points.append(self._point(load, self._measure(), points[0].velocity))
            yield points[-1]

    def state(self) -> dict[str, NDArray]:
        """What the ride and the gait's clock are at, between two points; see `Ride.state`."""
        return self.ride.state() | {"started": np.array(self._started)}

    def restore(self, state: Mapping[str, NDArray]) -> None:
        """Go on from what `state` gave of the same vehicle, law and gait."""
        self.ride.restore(state)
        self._started = float(state["started"])

    @staticmethod
    def _point(load: float, found: _Measured, free: float) -> DrawbarPoint:
        return DrawbarPoint(load, found.velocity, float(travel_reduction(found.velocity, free)), found.phases)

    def _measure(self) -> _Measured:
        return self._measure_cycles() if self.gait.cycle else self._measure_way()

    def _measure_cycles(self) -> _Measured:
        """Velocity over the last cycle: one distance at the start of each."""
        assert self.gait.cycle
        distances = [self.ride.travel]
        for _ in range(self._cycles):
            balance = self._ride_on(self.gait.cycle)
            distances.append(self.ride.travel)
            if distances[-1] - distances[-2] < -_PULLED_BACK:
                break
        return _Measured(float(velocities(distances, self.gait.cycle)[-1]), balance.means())

    def _measure_way(self) -> _Measured:
        """Velocity over the later half of a load step: distances at 1 Hz, or six in its usual time.

        A step ends after its way, or when a rover that is nearly stuck no longer changes its speed.
        """
        distances, balances = [self.ride.travel], []
        sampling = self._sampling()
        while len(distances) <= _LONGEST * self._usual / sampling:
            balances.append(self._ride_on(sampling))
            distances.append(self.ride.travel)
            gone = distances[-1] - distances[0]
            gone_far = gone > ROLLING_STEP and len(distances) > _FEWEST_SAMPLES
            if gone < -_PULLED_BACK or gone_far or self._settled(distances, sampling):
                break
        later = len(balances) // 2
        velocity = float(velocities(distances[later:], sampling).mean())
        return _Measured(velocity, means_over(balances[later:]))

    @property
    def _usual(self) -> float:
        """Time that a step takes without a load, s."""
        return ROLLING_STEP / self.gait.speed

    def _sampling(self) -> float:
        """Time between two distances, s: whole time steps."""
        step = self.ride.time_step
        return round(min(_SAMPLING, self._usual / _FEWEST_SAMPLES) / step) * step

    def _settled(self, distances: Sequence[float], sampling: float) -> bool:
        """Whether a rover that took longer than a step takes without a load keeps its speed."""
        if len(distances) < max(self._usual / sampling, 3 * _SETTLED_OVER):
            return False
        found = velocities(distances, sampling)
        late, before = found[-_SETTLED_OVER:], found[-2 * _SETTLED_OVER : -_SETTLED_OVER]
        return abs(float(late.mean() - before.mean())) < _SETTLED_TO * self.gait.speed

    def _ride_on(self, duration: float) -> Balance:
        balance = Balance(self.ride)
        for _ in range(round(duration / self.ride.time_step)):
            time = self.ride.time - self._started
            self.ride.step(self.gait.command(time))
            balance.add(self.gait.phase(time))
        return balance

    def _tension(self, pull: float) -> None:
        """Raise the cable's tension while the gait goes on; a cycle's clock stands meanwhile."""
        start, count = self.ride.pull, round(_TENSIONING / self.ride.time_step)
        waiting = self.gait.command(self.ride.time - self._started) if self.gait.cycle else None
        for step in range(count):
            self.ride.pull = start + (pull - start) * (step + 1) / count
            told = self.gait.command(self.ride.time - self._started) if waiting is None else waiting
            self.ride.step(told)
        if waiting is not None:
            self._started += count * self.ride.time_step

    def _settle(self) -> None:
        held = self.gait.command(0.0)
        for _ in range(round(_SETTLING / self.ride.time_step)):
            self.ride.step(held)
