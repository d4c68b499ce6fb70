"""Where the work of a ride goes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synth.rover.ride import Ride


@dataclass(frozen=True)
class Work:
    """Energy since the start, J.

    Attributes
    ----------
    motors : float
        Done by the actuators on the vehicle.
    soil : float
        Done by the vehicle on the soil, sideways slip not counted.
    cable : float
        Done by the vehicle on the cable.
    stored : float
        Gain of the vehicle's kinetic and potential energy.
    """

    motors: float
    soil: float
    cable: float
    stored: float

    @property
    def missing(self) -> float:
        """What went in and is found nowhere, J: numerical damping, and what soft constraints take."""
        return self.motors - self.soil - self.cable - self.stored


class EnergyLedger:
    """Adds up the work of every step of a ride: force times the way until the next step.

    Parameters
    ----------
    ride : Ride
    """

    def __init__(self, ride: Ride) -> None:
        self._ride = ride
        self._start = self._stored()
        self._motors = self._soil = self._cable = 0.0
        self._before = self._ways()

    def add(self) -> None:
        """Count the step that the ride has just done."""
        import mujoco

        ride, data = self._ride, self._ride.data
        mujoco.mj_fwdPosition(ride.model, data)
        now = self._ways()
        way = [after - before for after, before in zip(now, self._before, strict=True)]
        forces = ride.forces
        self._motors += float(np.dot(data.actuator_force, way[0]))
        self._soil -= float(
            np.dot(forces.force_x, way[1]) + np.dot(forces.force_z, way[2]) + np.dot(forces.torque, way[3])
        )
        self._cable += ride.pull * float(way[1][ride.vehicle.rear_wheels].mean())
        self._before = now

    def work(self) -> Work:
        """Until now."""
        return Work(self._motors, self._soil, self._cable, self._stored() - self._start)

    def _stored(self) -> float:
        """Kinetic and potential energy of the vehicle, J."""
        import mujoco

        ride = self._ride
        mujoco.mj_energyPos(ride.model, ride.data)
        mujoco.mj_energyVel(ride.model, ride.data)
        return float(ride.data.energy.sum())

    def _ways(self) -> tuple[NDArray, ...]:
        states = self._ride.wheel_states()
        return self._ride.data.actuator_length.copy(), states.x, states.z, states.angle
