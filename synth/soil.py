"""What a soil is: published values of the material and the contact values of its model grains."""

from typing import Self

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
    """

    name: str
    description: str
    bulk_density: float = Field(gt=0, description="kg/m3")
    grain_sizes: GrainSizes
    contact: GrainContact
    look: Look
