"""A curve of travel reduction against drawbar pull: what to measure, and what was measured."""

from dataclasses import asdict, dataclass, field
from typing import Any

from synth.rover.drawbar import DrawbarPoint, LoadSteps
from synth.rover.gaits import DEFAULT_SPEED
from synth.rover.travel_reduction import pull_at

REDUCTIONS = (0.1, 0.2, 0.4)
"""Travel reductions at which curves are compared."""


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
        As `synth.rover.law.catalogue.make_law` has them.
    steps : LoadSteps
    speed : float
        Of the rim, m/s.
    time_step : float or None
        s; None: the model's own.
    soil : str or None
        File that `softbed identify` wrote; None: loose GRC-1 by published values.
    """

    vehicle: str
    gait: str
    wheel: str
    law: str
    steps: LoadSteps = field(default_factory=LoadSteps)
    speed: float = DEFAULT_SPEED
    time_step: float | None = None
    soil: str | None = None

    @property
    def name(self) -> str:
        """Names its file."""
        return f"{self.gait}-{self.wheel}-{self.law}"

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
        """Drawbar pull over weight at which the vehicle stands; the greatest load, if it never does."""
        standing = self._pull_at(1.0)
        return self.points[-1].drawbar_pull_ratio if standing is None else standing

    @property
    def reached(self) -> bool:
        """Whether the loads went up to where the vehicle stands."""
        return self.points[-1].travel_reduction >= 1

    @property
    def moving(self) -> tuple[DrawbarPoint, ...]:
        """Points at which the vehicle moves forward."""
        return tuple(point for point in self.points if point.travel_reduction < 1)

    @property
    def at_travel_reduction(self) -> dict[str, float | None]:
        """Drawbar pull over weight at travel reductions; None where the loads did not get there."""
        return {f"{reduction:g}": self._pull_at(reduction) for reduction in REDUCTIONS}

    def to_dict(self) -> dict[str, Any]:
        """As JSON holds it."""
        points = [point.to_dict() for point in self.points]
        return {"order": self.order.to_dict(), "vehicle_weight": self.vehicle_weight, "points": points}

    @staticmethod
    def from_dict(told: dict[str, Any]) -> "Curve":
        """From what `to_dict` gave."""
        points = tuple(DrawbarPoint.from_dict(point) for point in told["points"])
        return Curve(CurveOrder.from_dict(told["order"]), told["vehicle_weight"], points)

    def _pull_at(self, reduction: float) -> float | None:
        pulls = [point.drawbar_pull_ratio for point in self.points]
        return pull_at(reduction, pulls, [point.travel_reduction for point in self.points])
