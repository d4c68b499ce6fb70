"""Friction and rolling friction of the model grains from a soil's published friction angle.

One equation, two unknowns: the pair is not unique. Friction between grains is a property of their
material, which is known (silica on silica about 0.5), and it sets how a packing dilates; rolling friction
stands for the grains' shape, which discs have not, and nothing else tells it. So the first is taken from the
soil's file and the second is searched for. Rolling friction also changes how loosely grains settle: the
limits of the void ratio are measured anew for each one tried, and samples are prepared to the bed's
*relative* density between them.
"""

from dataclasses import dataclass

import numpy as np

from synth.dem.relative_density import SettlingRelation, settling_relation
from synth.soil import GrainContact, Packing, Soil, SoilFile
from validation.calibration.biaxial import BiaxialPoint, measure_point
from validation.calibration.plate import PlateCurve, press_plate
from validation.calibration.search import OutOfReachError, search
from validation.verification.comparison import Progress
from validation.verification.packing import POLYDISPERSITY

TOLERANCE = 0.5
"""deg; a friction angle this near to the published one is not searched on."""
RESOLUTION = 0.05
"""Of rolling friction: about half a degree, which is the standard error of a few seeds."""
LARGEST = 1.0
"""Rolling friction that a soil's file allows at most."""
_PLATE_SEEDS = (1, 2, 3, 4)
_PARTS = 12
"""Parts of the work that are told of: points of the biaxial test, at most, and the plate's beds."""


class CalibrationError(ValueError):
    """A soil that cannot be calibrated; the message names key, value and what is allowed."""


@dataclass(frozen=True)
class Target:
    """What is published of the bed as it is prepared.

    Attributes
    ----------
    relative_density : float
        0 loosest, 1 densest.
    friction_angle : float
        Peak, deg.
    """

    relative_density: float
    friction_angle: float

    @classmethod
    def of(
        cls, soil: SoilFile, *, relative_density: float | None = None, friction_angle: float | None = None
    ) -> "Target":
        """From the soil's table `published` and its bulk density, but for what is given.

        Raises
        ------
        CalibrationError
            The soil's file does not tell, or tells a density outside its own range.
        """
        published = soil.published
        if published is None and (relative_density is None or friction_angle is None):
            raise CalibrationError(
                f"soil {soil.name!r} has no table [published]: add one, or give both --relative-density and "
                "--friction-angle"
            )
        if relative_density is None:
            assert published is not None
            relative_density = published.relative_density(soil.bulk_density)
            if not 0 <= relative_density <= 1:
                raise CalibrationError(
                    f"soil {soil.name!r}: bulk_density = {soil.bulk_density}: allowed is "
                    f"{published.loosest_density} to {published.densest_density}, its published range"
                )
        if friction_angle is None:
            assert published is not None
            friction_angle = published.friction_angle(relative_density)
        return cls(relative_density, friction_angle)


@dataclass(frozen=True)
class Calibration:
    """What was aimed at and what was found.

    Attributes
    ----------
    soil : Soil
        With the contact values and the packing found.
    target : Target
    tried : tuple of BiaxialPoint
        By rolling friction, at the target's relative density.
    loosest, densest : BiaxialPoint
        At relative densities 0 and 1, with the contact values found: not fitted to.
    relation : SettlingRelation
    plate : PlateCurve
    """

    soil: Soil
    target: Target
    tried: tuple[BiaxialPoint, ...]
    loosest: BiaxialPoint
    densest: BiaxialPoint
    relation: SettlingRelation
    plate: PlateCurve

    @property
    def found(self) -> BiaxialPoint:
        """The point of the rolling friction found."""
        chosen = self.soil.contact.rolling_friction
        return next(point for point in self.tried if point.rolling_friction == chosen)


def calibrate(soil: Soil, target: Target, *, seed_count: int, progress: Progress) -> Calibration:
    """Search for the rolling friction that gives the target's friction angle, then press a plate.

    `synth.devices.start_taichi` must have been called.

    Raises
    ------
    CalibrationError
        No rolling friction gives that angle; the message says which angles there are.
    """
    work = _Work(soil, tuple(range(1, seed_count + 1)), progress)
    sine, slack = _sine(target.friction_angle), _sine(target.friction_angle + TOLERANCE)
    try:
        rolling_friction = search(
            lambda value: work.point(value, target.relative_density).mean,
            sine,
            low=0.0,
            high=LARGEST,
            resolution=RESOLUTION,
            tolerance=slack - sine,
        )
    except OutOfReachError:
        raise CalibrationError(_out_of_reach(work, target)) from None
    tried = work.points
    relation = work.relation(rolling_friction)
    packing = Packing(
        polydispersity=POLYDISPERSITY,
        rolling_friction=rolling_friction,
        restitution=soil.contact.restitution,
        friction=list(relation.friction),
        void_ratio=[round(value, 4) for value in relation.void_ratio],
    )
    calibrated = soil.model_copy(update={"contact": work.contact(rolling_friction), "packing": packing})
    loosest, densest = (work.point(rolling_friction, end) for end in (0.0, 1.0))
    plate = press_plate(
        calibrated,
        POLYDISPERSITY,
        settling_friction=relation.friction_for(target.relative_density),
        seeds=_PLATE_SEEDS,
        progress=work.part(_PARTS - 2, 2),
    )
    by_friction = tuple(sorted(tried, key=lambda point: point.rolling_friction))
    return Calibration(calibrated, target, by_friction, loosest, densest, relation, plate)


class _Work:
    """Points of the biaxial test, each done once, and what was told of them."""

    def __init__(self, soil: Soil, seeds: tuple[int, ...], progress: Progress) -> None:
        self._soil, self._seeds, self._progress = soil, seeds, progress
        self._points: dict[tuple[float, float], BiaxialPoint] = {}

    @property
    def points(self) -> list[BiaxialPoint]:
        """All so far."""
        return list(self._points.values())

    def contact(self, rolling_friction: float) -> GrainContact:
        """The soil's, with another rolling friction."""
        return self._soil.contact.model_copy(update={"rolling_friction": rolling_friction})

    def relation(self, rolling_friction: float, progress: Progress | None = None) -> SettlingRelation:
        """How such grains settle."""
        return settling_relation(self.contact(rolling_friction), POLYDISPERSITY, progress=progress)

    def point(self, rolling_friction: float, relative_density: float) -> BiaxialPoint:
        """The biaxial test of such grains at such a density."""
        rolling_friction = round(rolling_friction, 6)  # a multiple of the resolution, as it is written
        key = rolling_friction, relative_density
        if key not in self._points:
            part = min(len(self._points), _PARTS - 3)
            relation = self.relation(rolling_friction, self.part(part, 0.5))
            self._points[key] = measure_point(
                self.contact(rolling_friction),
                POLYDISPERSITY,
                relation,
                relative_density=relative_density,
                seeds=self._seeds,
                progress=self.part(part + 0.5, 0.5),
            )
        return self._points[key]

    def part(self, before: float, share: float) -> Progress:
        """Progress of a part of the work as progress of the whole, in hundredths of parts."""
        return lambda done, total: self._progress(round(100 * (before + share * done / total)), 100 * _PARTS)


def _sine(angle: float) -> float:
    return float(np.sin(np.radians(angle)))


def _out_of_reach(work: _Work, target: Target) -> str:
    lowest, highest = (work.point(end, target.relative_density) for end in (0.0, LARGEST))
    return (
        f"friction angle = {target.friction_angle:.1f} deg, relative density {target.relative_density:.2f}: "
        f"allowed is {lowest.angle:.1f} to {highest.angle:.1f} deg with contact.friction = {lowest.friction} "
        f"(rolling friction 0 to {LARGEST:g}); another contact.friction reaches others"
    )
