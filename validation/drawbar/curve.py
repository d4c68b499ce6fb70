"""A curve of travel reduction against drawbar pull: what to measure, and what was measured."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from synth.rover.drawbar import DrawbarPoint, LoadSteps
from synth.rover.gaits import DEFAULT_SPEED
from synth.rover.travel_reduction import pull_at as pull_between

WHEELS = ("rigid", "pneumatic")
REDUCTIONS = (0.1, 0.2, 0.4)
"""Travel reductions at which curves are compared."""
HIGH_REDUCTION = 0.9
"""Where the drawbar pull counts as the maximum: "near the top of the figure" (the paper's Fig. 17)."""
GRAINS = "dem"
"""In the place of a law: the granular simulator."""
GRAIN_LOADS = (0.08, 0.16, 0.24)
"""Drawbar pulls over weight that take it some minutes."""
GRAIN_SPEED = 0.18
"""m/s of the rim: three times the rover's, so that it takes a third of the time."""
REPEAT_CHANGE = 0.004
"""Of the rim's speed from one repeat to the next: nothing that soil or vehicle feel, but another history."""
COARSE_STEPS = {"rolling": 0.012, "inching": 0.016}
"""Steps of drawbar pull over weight; an inching cycle takes longer than half a metre of rolling."""


@dataclass(frozen=True)
class CurveOrder:
    """A curve to measure.

    Attributes
    ----------
    vehicle : str
        MJCF file, or the name of a shipped vehicle.
    gait : str
        `rolling` or `inching`.
    wheel, law : str
        As `synth.rover.law.catalogue.make_law` has them; or law `GRAINS`.
    steps : LoadSteps
    speed : float
        Of the rim, m/s.
    time_step : float or None
        s; None: the model's own.
    soil : str or None
        File that `softbed identify` wrote; None: loose GRC-1 by published values.
    variation : str
        Name of what is changed of what is assumed, in `validation.drawbar.variation`; empty: nothing.
    repeat : int
        Number of the repeat, from 0; the rim's speed differs by `REPEAT_CHANGE` from one to the next.
    """

    vehicle: str
    gait: str
    wheel: str
    law: str
    steps: LoadSteps = field(default_factory=LoadSteps)
    speed: float = DEFAULT_SPEED
    time_step: float | None = None
    soil: str | None = None
    variation: str = ""
    repeat: int = 0

    @property
    def rim_speed(self) -> float:
        """Of this repeat, m/s."""
        return self.speed * (1 + REPEAT_CHANGE * self.repeat)

    @property
    def name(self) -> str:
        """Names its file."""
        repeat = f"repeat-{self.repeat}" if self.repeat else ""
        what = (self.gait, self.wheel, self.law, self.variation, repeat)
        return "-".join(part for part in what if part)

    @property
    def published_name(self) -> str:
        """Row of the published table."""
        return f"{self.gait}_{self.wheel}"

    def to_dict(self) -> dict[str, Any]:
        """As JSON holds it."""
        told = asdict(self)
        told["steps"]["loads"] = list(self.steps.loads)
        return told

    @staticmethod
    def from_dict(told: dict[str, Any]) -> "CurveOrder":
        """From what `to_dict` gave."""
        steps = LoadSteps(loads=tuple(told["steps"]["loads"]), coarse=told["steps"]["coarse"])
        return CurveOrder(**(told | {"steps": steps}))


def orders_of(
    vehicle: str,
    *,
    gaits: Sequence[str],
    wheels: Sequence[str] | None = None,
    laws: Sequence[str] | None = None,
    loads: Sequence[float] = (),
    speed: float | None = None,
    soil: str | None = None,
) -> list[CurveOrder]:
    """Every gait with every wheel and law; what is not told is as `softbed drawbar` has it.

    Parameters
    ----------
    soil : str, optional
        File that `softbed identify` wrote, or `GRAINS`.

    Raises
    ------
    ValueError
        Laws are told beside the grains.
    """
    grains = soil == GRAINS
    if grains and laws:
        raise ValueError(f"law = {', '.join(laws)}: none beside --soil {GRAINS}, which is no law")
    loads = tuple(loads) or (GRAIN_LOADS if grains else ())
    return [
        CurveOrder(
            vehicle,
            gait,
            wheel,
            law,
            LoadSteps(loads=tuple(loads), coarse=COARSE_STEPS.get(gait, COARSE_STEPS["rolling"])),
            speed=(GRAIN_SPEED if grains else DEFAULT_SPEED) if speed is None else speed,
            soil=None if grains else soil,
        )
        for law in ([GRAINS] if grains else laws or ["rft"])
        for wheel in wheels or (["rigid"] if grains else WHEELS)
        for gait in gaits
    ]


def repeated(orders: Sequence[CurveOrder], count: int) -> list[CurveOrder]:
    """The same orders again, until each is there `count` times; without the first ones."""
    return [replace(order, repeat=repeat) for repeat in range(1, count) for order in orders]


@dataclass(frozen=True)
class Curve:
    """A curve that was measured.

    Attributes
    ----------
    order : CurveOrder
    vehicle_weight : float
        N.
    points : tuple of DrawbarPoint
        In rising order of the load; the last may be one at which the vehicle is pulled back.
    """

    order: CurveOrder
    vehicle_weight: float
    points: tuple[DrawbarPoint, ...]

    @property
    def maximum(self) -> float:
        """Drawbar pull over weight at `HIGH_REDUCTION`; the greatest load, if it was not reached."""
        high = self.pull_at(HIGH_REDUCTION)
        return self.points[-1].drawbar_pull_ratio if high is None else high

    @property
    def reached(self) -> bool:
        """Whether the loads went up to `HIGH_REDUCTION`."""
        return max(point.travel_reduction for point in self.points) >= HIGH_REDUCTION

    @property
    def moving(self) -> tuple[DrawbarPoint, ...]:
        """Points at which the vehicle moves forward."""
        return tuple(point for point in self.points if point.travel_reduction < 1)

    @property
    def at_travel_reduction(self) -> dict[str, float | None]:
        """Drawbar pull over weight at travel reductions; None where the loads did not get there."""
        return {f"{reduction:g}": self.pull_at(reduction) for reduction in REDUCTIONS}

    def to_dict(self) -> dict[str, Any]:
        """As JSON holds it."""
        points = [point.to_dict() for point in self.points]
        return {"order": self.order.to_dict(), "vehicle_weight": self.vehicle_weight, "points": points}

    @staticmethod
    def from_dict(told: dict[str, Any]) -> "Curve":
        """From what `to_dict` gave."""
        points = tuple(DrawbarPoint.from_dict(point) for point in told["points"])
        return Curve(CurveOrder.from_dict(told["order"]), told["vehicle_weight"], points)

    def pull_at(self, reduction: float) -> float | None:
        """Drawbar pull over weight at a travel reduction; None where the loads did not get there."""
        pulls = [point.drawbar_pull_ratio for point in self.points]
        return pull_between(reduction, pulls, [point.travel_reduction for point in self.points])
