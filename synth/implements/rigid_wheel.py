"""A rigid wheel, smooth or with grousers."""

from typing import Literal

import numpy as np
from pydantic import Field

from synth.implements.shape import Shape
from synth.table import Table


class RigidWheel(Table):
    """A smooth cylinder, half the width and half the load of the wheel it stands for.

    The half-width wheel stands against the glass, which is the symmetry plane (paper, section 1). The
    simulation is plane strain: forces are computed per metre of width and multiplied by `width`.
    """

    kind: Literal["rigid_wheel"]
    radius: float = Field(gt=0, le=1, description="m")
    width: float = Field(gt=0, le=1, description="m, of the half-width wheel")
    normal_load: float = Field(gt=0, description="N, on the half-width wheel: weight and dead load")
    moving_mass: float = Field(gt=0, description="kg, that rises and sinks with the axle; not its weight")

    @property
    def shape(self) -> Shape:
        """The rim."""
        return Shape.disc(self.radius)


class GrouserWheel(RigidWheel):
    """A rigid wheel with straight radial grousers, evenly spaced."""

    kind: Literal["grouser_wheel"]  # type: ignore[assignment]
    grouser_count: int = Field(ge=1, le=200)
    grouser_height: float = Field(gt=0, le=0.2, description="m, above the rim")
    grouser_thickness: float = Field(gt=0, le=0.05, description="m")

    @property
    def shape(self) -> Shape:
        """Rim and grousers; the grousers' tips are round."""
        half = self.grouser_thickness / 2
        angle = 2 * np.pi * np.arange(self.grouser_count) / self.grouser_count
        outwards = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        count = self.grouser_count
        grousers = Shape(
            outwards * (self.radius - half),
            outwards * (self.radius + self.grouser_height - half),
            np.full(count, half),
            np.zeros(count, bool),
        )
        return Shape.disc(self.radius).joined(grousers)
