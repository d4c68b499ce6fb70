"""Wheelbase and the angle between the arms of a side-frame.

Both arms of a side-frame are as long, and both shoulders of a vehicle on one axis, so that with L the arm
from shoulder to hub, wheelbase = 2 L sin(spread / 2) and the shoulder stands L cos(spread / 2) above the
hubs.
"""

import math
from dataclasses import dataclass

import numpy as np

from synth.rover.vehicle import Vehicle, VehicleError

SPREADS = ("left_spread", "right_spread")
"""Servos of the angle between the arms of either side-frame, and their tendons."""


@dataclass(frozen=True)
class SideFrame:
    """Both arms of a side.

    Attributes
    ----------
    arm_length : float
        From shoulder to hub, m.
    shortest, longest : float
        Wheelbase that the servo and the joints allow, m.
    """

    arm_length: float
    shortest: float
    longest: float

    def spread(self, wheelbase: float) -> float:
        """Angle between the arms, rad."""
        return 2 * math.asin(wheelbase / (2 * self.arm_length))

    def wheelbase(self, spread: float) -> float:
        """Distance of the axles at an angle between the arms, m."""
        return 2 * self.arm_length * math.sin(spread / 2)

    def require(self, wheelbase: float) -> None:
        """Refuse a wheelbase out of reach.

        Raises
        ------
        VehicleError
            With the range that is allowed.
        """
        if not self.shortest <= wheelbase <= self.longest:
            raise VehicleError(
                f"wheelbase {wheelbase:g} m: this vehicle allows {self.shortest:.2f} to {self.longest:.2f} m"
            )


def side_frame(vehicle: Vehicle) -> SideFrame:
    """The side-frame of a vehicle that can change its wheelbase.

    Raises
    ------
    VehicleError
        It has no servos `left_spread` and `right_spread`, or its arms differ.
    """
    model = vehicle.model
    servos = [vehicle.actuator(name) for name in SPREADS]
    lengths = [_arm_length(vehicle, wheel.body) for wheel in vehicle.wheels]
    if not np.allclose(lengths, lengths[0]):
        raise VehicleError(f"{vehicle.path}: arms of different lengths, {lengths} m")
    frame = SideFrame(float(lengths[0]), 0.0, math.inf)
    low, high = (frame.wheelbase(float(angle)) for angle in model.actuator_ctrlrange[servos[0]])
    return SideFrame(frame.arm_length, low, high)


def _arm_length(vehicle: Vehicle, wheel: int) -> float:
    """From the shoulder to the hub in the plane of the wheel, m."""
    x, _, z = vehicle.model.body_pos[wheel]
    return math.hypot(x, z)
