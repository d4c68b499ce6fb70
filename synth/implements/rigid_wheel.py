"""A rigid wheel on a carriage: constant slip, free sinkage under a dead load."""

from typing import Literal

from pydantic import Field

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
    rim_speed: float = Field(gt=0, description="m/s, radius x angular velocity")
    slip: float = Field(ge=0, lt=1, description="1 - carriage speed / rim speed (paper, Eq. 1)")
    start: float = Field(gt=0, description="m, axle's distance from the left end wall at touch-down")
    run_in: float = Field(ge=0, description="m of travel before the first frame")

    @property
    def carriage_speed(self) -> float:
        """Horizontal speed of the axle, m/s (paper, Eq. 1 solved for it)."""
        return self.rim_speed * (1 - self.slip)

    @property
    def angular_velocity(self) -> float:
        """Rate of turning about y, rad/s, counter-clockwise positive: negative drives towards +x."""
        return -self.rim_speed / self.radius
