"""A wedge that parts the soil ahead of it."""

from typing import Literal

import numpy as np
from pydantic import Field

from synth.implements.shape import Shape
from synth.table import Table


class Wedge(Table):
    """A solid wedge; its reference point is the tip, and it cuts towards +x."""

    kind: Literal["wedge"]
    width: float = Field(gt=0, le=1, description="m, of the half-width wedge")
    angle: float = Field(gt=0, lt=90, description="deg, of the face above the horizontal")
    height: float = Field(gt=0, le=1, description="m")

    @property
    def shape(self) -> Shape:
        """Face, back, and an underside that rises behind the tip."""
        heel = -self.height / np.tan(np.deg2rad(self.angle))
        return Shape.outline(np.array([[0.0, 0.0], [heel, self.height], [heel, self.height / 3]]))
