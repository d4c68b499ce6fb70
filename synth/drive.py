"""How the carriage drives an implement: programs of speed, turning and load over the laboratory's time."""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from synth.implements import Implement, RigidWheel
from synth.table import Table

_RAMP_SHARE = 0.2
"""Share of a run-in over which load and speed grow from nothing: a soft touch-down."""


@dataclass(frozen=True, eq=False)
class Program:
    """What the carriage does, linear between knots; time 0 is the first frame.

    Attributes
    ----------
    time : ndarray, shape (K,)
        s, in the laboratory, ascending.
    velocity_x, velocity_z, spin : ndarray, shape (K,)
        m/s and rad/s; rotation counter-clockwise positive, so a wheel that drives towards +x has a negative
        one.
    load : ndarray, shape (K,)
        Share of the dead load that presses on the implement.
    heaves : bool
        The implement rises and sinks under its load; else at `velocity_z`.
    """

    time: np.ndarray
    velocity_x: np.ndarray
    velocity_z: np.ndarray
    spin: np.ndarray
    load: np.ndarray
    heaves: bool

    @classmethod
    def of(cls, knots: list[tuple[float, float, float, float, float]], *, heaves: bool) -> "Program":
        """From (time, velocity_x, velocity_z, spin, load) a knot."""
        time, velocity_x, velocity_z, spin, load = np.array(knots, float).T
        return cls(time, velocity_x, velocity_z, spin, load, heaves)

    def at(self, time: float) -> tuple[float, float, float, float]:
        """velocity_x, velocity_z, spin and load at a time; before the first and after the last as there."""
        columns = (self.velocity_x, self.velocity_z, self.spin, self.load)
        vx, vz, spin, load = (float(np.interp(time, self.time, column)) for column in columns)
        return vx, vz, spin, load

    def travel(self, time: float) -> float:
        """Travel along the bin since touch-down at a time, m."""
        knots = np.append(self.time[self.time < time], time)
        speed = np.interp(knots, self.time, self.velocity_x)
        return float(np.trapezoid(speed, knots))

    def reach_x(self, end: float) -> tuple[float, float]:
        """Least and greatest travel along the bin up to the time `end`, m."""
        times = np.unique(np.append(np.linspace(self.time[0], end, 2001), self.time[self.time <= end]))
        speed = np.interp(times, self.time, self.velocity_x)
        travel = np.concatenate([[0.0], np.cumsum(np.diff(times) * (speed[1:] + speed[:-1]) / 2)])
        return float(travel.min()), float(travel.max())


class Rolling(Table):
    """A driven wheel at constant slip, sinking freely under its dead load."""

    kind: Literal["rolling"]
    rim_speed: float = Field(gt=0, description="m/s, radius x angular velocity")
    slip: float = Field(ge=0, lt=1, description="1 - carriage speed / rim speed (paper, Eq. 1)")
    start: float = Field(gt=0, description="m, axle's distance from the left end wall at touch-down")
    run_in: float = Field(ge=0, description="m of travel before the first frame")

    @property
    def carriage_speed(self) -> float:
        """Horizontal speed of the axle, m/s (paper, Eq. 1 solved for it)."""
        return self.rim_speed * (1 - self.slip)

    def program(self, implement: Implement) -> Program:
        """Touch down while already rolling, then constant speed."""
        wheel = _wheel(implement, self.kind)
        full = (self.carriage_speed, 0.0, -self.rim_speed / wheel.radius, 1.0)
        if self.run_in == 0:
            return Program.of([(0.0, *full), (1.0, *full)], heaves=True)
        ramp = 2 * _RAMP_SHARE * self.run_in / self.carriage_speed
        begin = -(self.run_in / self.carriage_speed + ramp / 2)
        return Program.of([(begin, 0.0, 0.0, 0.0, 0.0), (begin + ramp, *full), (0.0, *full)], heaves=True)


class Pushing(Table):
    """A braked wheel, loaded and then pushed backwards: the static wheel of push-rolling.

    The wheel stands under its load, rotation held at zero, and is pushed opposite to the vehicle's direction
    (paper, section 4.1.2). Rolled in first, it has come to its place by rolling, as behind a rover.
    """

    kind: Literal["pushing"]
    speed: float = Field(gt=0, description="m/s, towards -x")
    start: float = Field(gt=0, description="m, axle's distance from the left end wall at touch-down")
    loading: float = Field(gt=0, description="s over which the load grows")
    rest: float = Field(ge=0, description="s at rest under the load before the push")
    rolled_in: float = Field(default=0.0, ge=0, description="m rolled, without slip, before it rests")

    def program(self, implement: Implement) -> Program:
        """Load, roll in if asked, rest, push from time 0."""
        wheel = _wheel(implement, self.kind)
        ramp = 0.1 * self.loading
        rolling = (self.speed, 0.0, -self.speed / wheel.radius, 1.0)
        still = (0.0, 0.0, 0.0, 1.0)
        knots = [(-self.rest, *still), (0.0, *still), (ramp, -self.speed, 0.0, 0.0, 1.0)]
        if self.rolled_in > 0:
            stop = -self.rest - ramp
            begin = stop - self.rolled_in / self.speed
            knots = [(begin - ramp, *still), (begin, *rolling), (stop, *rolling), *knots]
        first = knots[0][0] - self.loading
        return Program.of([(first, 0.0, 0.0, 0.0, 0.0), *knots], heaves=True)


class Cutting(Table):
    """A tool drawn horizontally at a constant depth, after it has gone down to it."""

    kind: Literal["cutting"]
    speed: float = Field(gt=0, description="m/s, towards +x")
    depth: float = Field(gt=0, description="m, of the lowest point below the surface")
    start: float = Field(gt=0, description="m, reference point's distance from the left end wall at first")
    run_in: float = Field(gt=0, description="m of travel before the first frame")

    def program(self, implement: Implement) -> Program:
        """Go down over the first half of the run-in, moving forward all the time."""
        duration = self.run_in / self.speed
        down = (self.speed, -self.depth / (0.5 * duration))
        level = (self.speed, 0.0, 0.0, 0.0)
        knots = [(-duration, *down, 0.0, 0.0), (-0.5 * duration, *down, 0.0, 0.0)]
        return Program.of([*knots, (-0.5 * duration, *level), (0.0, *level)], heaves=False)


class Towed(Table):
    """A wheel that turns slower than it travels, held back by its brake, sinking freely under its load."""

    kind: Literal["towed"]
    speed: float = Field(gt=0, description="m/s, of the carriage, towards +x")
    skid: float = Field(ge=-1, lt=0, description="rim speed / carriage speed - 1; -1: locked")
    start: float = Field(gt=0, description="m, axle's distance from the left end wall at touch-down")
    run_in: float = Field(gt=0, description="m of travel before the first frame")

    def program(self, implement: Implement) -> Program:
        """Touch down while already moving, then constant speed."""
        wheel = _wheel(implement, self.kind)
        full = (self.speed, 0.0, -self.speed * (1 + self.skid) / wheel.radius, 1.0)
        ramp = 2 * _RAMP_SHARE * self.run_in / self.speed
        begin = -(self.run_in / self.speed + ramp / 2)
        return Program.of([(begin, 0.0, 0.0, 0.0, 0.0), (begin + ramp, *full), (0.0, *full)], heaves=True)


class PushRolling(Table):
    """A wheel's whole cycle of push-rolling: it rolls, is braked, is pushed backwards, and rolls on.

    (Paper, section 4.1: each wheel in turn rolls while the other one is static.) Every phase ends in a rest.
    """

    kind: Literal["push_rolling"]
    speed: float = Field(gt=0, description="m/s, of the carriage, forwards and backwards")
    slip: float = Field(
        ge=0, lt=1, description="while it rolls: 1 - carriage speed / rim speed (paper, Eq. 1)"
    )
    start: float = Field(gt=0, description="m, axle's distance from the left end wall at touch-down")
    loading: float = Field(gt=0, description="s over which the load grows")
    rest: float = Field(gt=0, description="s at rest between the phases")
    rolled_in: float = Field(gt=0, description="m of travel before the first frame")
    pushed: float = Field(gt=0, description="m, backwards, the wheel braked")

    def program(self, implement: Implement) -> Program:
        """Load, roll in, rest, push from time 0, rest, roll on."""
        wheel = _wheel(implement, self.kind)
        rolling = (self.speed, 0.0, -self.speed / (1 - self.slip) / wheel.radius, 1.0)
        pushed = (-self.speed, 0.0, 0.0, 1.0)
        still = (0.0, 0.0, 0.0, 1.0)
        ramp = 0.25 * min(self.rest, self.rolled_in / self.speed, self.pushed / self.speed)
        # Two ramps, up and down, count as one of full speed.
        lasts = [
            (rolling, self.rolled_in / self.speed - ramp),
            (still, self.rest),
            (pushed, self.pushed / self.speed - ramp),
            (still, self.rest),
        ]
        time = -(self.rolled_in / self.speed + self.rest + ramp)
        knots = [(time - self.loading, 0.0, 0.0, 0.0, 0.0), (time, *still)]
        for state, duration in lasts:
            knots += [(time + ramp, *state), (time + ramp + duration, *state)]
            time += ramp + duration
        return Program.of([*knots, (time + ramp, *rolling)], heaves=True)


Drive = Annotated[Rolling | Pushing | Cutting | Towed | PushRolling, Field(discriminator="kind")]
"""How an implement can be driven."""


def _wheel(implement: Implement, drive: str) -> RigidWheel:
    if not isinstance(implement, RigidWheel):
        raise ValueError(f"drive.kind = {drive!r} needs a wheel, got implement.kind = {implement.kind!r}")
    return implement
