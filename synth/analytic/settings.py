"""The tables of an analytic scene besides its motion."""

from typing import Literal, Self

from pydantic import Field, model_validator

from synth.table import Table


class AnalyticTiming(Table):
    """How many pictures, and how often."""

    frame_rate: float = Field(gt=0, description="1/s")
    frame_count: int = Field(default=2, ge=2, le=10_000)


class AnalyticCamera(Table):
    """A camera at rest before soil that fills the picture."""

    width: int = Field(ge=32, le=8192, description="px")
    height: int = Field(ge=32, le=8192, description="px")
    metres_per_pixel: float = Field(gt=0, le=0.01, description="m/px")
    scored_radius: float | None = Field(
        default=None, gt=0, description="px; further from the picture's middle no motion is said to be known"
    )


class GaussianGrains(Table):
    """Round grains, each as bright as a Gaussian.

    A grain of diameter d is the Gaussian with the second moment of a disc of that diameter: its standard
    deviation is d / 4. Diameters are uniform between the ends, places and greys are random.
    """

    smallest: float = Field(ge=0.2, le=100, description="px, least diameter")
    largest: float = Field(ge=0.2, le=100, description="px, greatest diameter")
    coverage: float = Field(gt=0, le=10, description="area of all grains / area of the picture")
    mean: float = Field(gt=0, lt=255, description="grey levels of 0-255")
    contrast: float = Field(
        gt=0, le=120, description="grey levels, standard deviation of the picture before noise"
    )

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.largest < self.smallest:
            raise ValueError(f"largest = {self.largest} px: at least smallest = {self.smallest} px is needed")
        return self


class AnalyticLens(Table):
    """What the lens does before the pixels integrate."""

    blur: float = Field(ge=0, le=20, description="px, standard deviation of the point spread function")


class AnalyticSensor(Table):
    """From light to grey levels."""

    bits: Literal[8, 16]
    noise: float = Field(ge=0, le=100, description="grey levels of 0-255, standard deviation")
    gain: float = Field(default=1.0, gt=0, le=4, description="of every second frame against the others")
    offset: float = Field(
        default=0.0, ge=-255, le=255, description="grey levels of 0-255, of every second frame"
    )
