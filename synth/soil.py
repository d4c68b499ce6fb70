"""What a soil is: published values of the material and the contact values of its model grains."""

from itertools import pairwise
from typing import Any, Self

from pydantic import Field, model_validator

from synth.table import Table


class GrainSizes(Table):
    """Distribution of grain diameters by mass: log-normal about the median, cut at both ends."""

    smallest: float = Field(gt=0, description="m")
    median: float = Field(gt=0, description="m")
    largest: float = Field(gt=0, description="m")
    log_deviation: float = Field(gt=0, le=2, description="standard deviation of ln(diameter), by mass")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.smallest < self.median < self.largest:
            raise ValueError(
                f"smallest < median < largest is needed, got {self.smallest}, {self.median}, {self.largest}"
            )
        return self


class GrainContact(Table):
    """Contact values of the model grains, grain against grain and grain against implement."""

    friction: float = Field(ge=0, le=2, description="Coulomb coefficient between grains")
    rolling_friction: float = Field(
        ge=0, le=1, description="rolling moment / (normal force x reduced radius)"
    )
    restitution: float = Field(ge=0.15, le=1, description="normal rebound speed / impact speed")
    wall_friction: float = Field(ge=0, le=2, description="Coulomb coefficient against floor and end walls")
    implement_friction: float = Field(ge=0, le=2, description="Coulomb coefficient against the implement")


class Packing(Table):
    """Void ratio that the model grains settle at, by the friction between them meanwhile, as measured.

    A measurement on grains of another contact or spread of sizes says nothing, so it names its own.
    """

    polydispersity: float = Field(
        ge=0, le=0.5, description="half-width of the uniform spread / mean diameter"
    )
    rolling_friction: float = Field(ge=0, le=1, description="as in the table contact")
    restitution: float = Field(ge=0.15, le=1, description="as in the table contact")
    friction: list[float] = Field(min_length=2, description="while settling, from 0 up")
    void_ratio: list[float] = Field(min_length=2, description="area of voids / area of grains, at each")

    @model_validator(mode="after")
    def _relates(self) -> Self:
        friction, voids = self.friction, self.void_ratio
        if len(friction) != len(voids):
            raise ValueError(
                f"as many void ratios as frictions are needed, got {len(voids)}, {len(friction)}"
            )
        if friction[0] != 0 or any(b <= a for a, b in pairwise(friction)):
            raise ValueError(f"friction must ascend from 0, got {friction}")
        if voids[0] <= 0 or voids[-1] <= voids[0] or any(b < a for a, b in pairwise(voids)):
            raise ValueError(f"void_ratio must rise with friction, got {voids}")
        return self

    def is_of(self, contact: GrainContact, polydispersity: float) -> bool:
        """Whether it was measured on such grains."""
        measured = self.rolling_friction, self.restitution, self.polydispersity
        return measured == (contact.rolling_friction, contact.restitution, polydispersity)


class Look(Table):
    """How grains look through the glass."""

    albedo: float = Field(gt=0, le=1, description="mean share of light a grain sends back")
    albedo_deviation: float = Field(ge=0, le=0.5, description="standard deviation from grain to grain")


class Soil(Table):
    """A soil.

    Attributes
    ----------
    bulk_density : float
        Density of the prepared bed, kg/m3.
    packing : Packing or None
        How densely the grains settle, if that has been measured.
    """

    name: str
    description: str
    bulk_density: float = Field(gt=0, description="kg/m3")
    grain_sizes: GrainSizes
    contact: GrainContact
    look: Look
    packing: Packing | None = None


class Published(Table):
    """What is published of a soil's density and strength: the ends of the range it can be prepared in."""

    loosest_density: float = Field(gt=0, description="kg/m3, bulk, at relative density 0")
    densest_density: float = Field(gt=0, description="kg/m3, bulk, at relative density 1")
    loosest_friction_angle: float = Field(gt=0, lt=60, description="deg, peak, at relative density 0")
    densest_friction_angle: float = Field(gt=0, lt=60, description="deg, peak, at relative density 1")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.loosest_density < self.densest_density:
            raise ValueError("loosest_density < densest_density is needed")
        if not self.loosest_friction_angle <= self.densest_friction_angle:
            raise ValueError("loosest_friction_angle <= densest_friction_angle is needed")
        return self

    def relative_density(self, bulk_density: float) -> float:
        """Relative density of a bed of that bulk density (kg/m3): linear in the void ratio."""
        loosest, densest = 1 / self.loosest_density, 1 / self.densest_density
        return (loosest - 1 / bulk_density) / (loosest - densest)

    def friction_angle(self, relative_density: float) -> float:
        """Peak friction angle, deg, linear between the ends."""
        loosest, densest = self.loosest_friction_angle, self.densest_friction_angle
        return loosest + relative_density * (densest - loosest)


class SoilFile(Soil):
    """A soil as its file tells of it: also what only a calibration reads.

    Attributes
    ----------
    published : Published or None
        What a calibration aims at.
    evidence : dict
        What a calibration found, for a person to read.
    """

    published: Published | None = None
    evidence: dict[str, Any] = Field(default_factory=dict)

    @property
    def soil(self) -> Soil:
        """What a scene carries of it."""
        return Soil(**{name: getattr(self, name) for name in Soil.model_fields})
