"""A bucket that cuts horizontally: a blade at a cut angle, and a back wall."""

from typing import Literal

import numpy as np
from pydantic import Field

from synth.implements.shape import Shape
from synth.table import Table


class Bucket(Table):
    """A bent plate; its reference point is the cutting edge, and it cuts towards +x.

    The blade rises backwards from the edge at the cut angle; the back wall stands upright at its end.
    """

    kind: Literal["bucket"]
    width: float = Field(gt=0, le=1, description="m, of the half-width bucket")
    cut_angle: float = Field(gt=0, lt=90, description="deg, of the blade above the horizontal")
    blade_length: float = Field(gt=0, le=1, description="m")
    back_height: float = Field(gt=0, le=1, description="m")
    thickness: float = Field(gt=0, le=0.05, description="m")

    @property
    def shape(self) -> Shape:
        """Blade and back wall, their edges round."""
        angle, half = np.deg2rad(self.cut_angle), self.thickness / 2
        heel = np.array([-np.cos(angle), np.sin(angle)]) * self.blade_length
        up = np.array([0.0, 1.0])
        return Shape.chain(np.stack([half * up, heel + half * up, heel + self.back_height * up]), half)
