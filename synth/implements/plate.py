"""A flat plate under a layer of soil, seen from above and turned about a pin (paper, section 3.1.1)."""

from typing import Literal

from pydantic import Field

from synth.table import Table


class Plate(Table):
    """A plate that carries its soil along rigidly."""

    kind: Literal["plate"]
    rotation: float = Field(ge=-0.5, le=0.5, description="rad a frame, counter-clockwise positive")
    pin_x: float = Field(description="m")
    pin_z: float = Field(description="m")
