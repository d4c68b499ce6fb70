"""A vehicle rides on soil: MuJoCo and a wheel-soil law in step."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from synth.rover.law.interface import Continuable, WheelForces, WheelSoilLaw, WheelStates
from synth.rover.vehicle import Vehicle

SIDE_FRICTION = 0.5
"""Sideways force over normal force of a wheel that slides sideways, which laws know nothing of; assumed."""
_SIDE_CREEP = 0.01
"""m/s; sideways velocity at which it is mobilised."""
_LAW = "law_"
"""Begins the names of the law's part of a state."""


class Ride:
    """A vehicle on undisturbed soil, advanced step by step.

    Parameters
    ----------
    vehicle : Vehicle
    law : WheelSoilLaw
        Taken over: the vehicle's wheels are placed on it.
    stance : str, optional
        Keyframe to start from; the model's first by default.
    time_step : float, optional
        s; the model's own by default.

    Attributes
    ----------
    pull : float
        Tension of the cable at the rear hubs, horizontal and backwards, N.
    forces : WheelForces
        Of the soil in the last step.
    states : WheelStates
        Of the wheels when these were asked for.
    sideways : ndarray, shape (wheel_count,)
        Velocity of the axles across the tracks then, m/s.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        law: WheelSoilLaw,
        *,
        stance: str | None = None,
        time_step: float | None = None,
    ) -> None:
        import mujoco

        self.vehicle, self.law = vehicle, law
        self.model = vehicle.model
        self.time_step = float(time_step or self.model.opt.timestep)
        self.model.opt.timestep = self.time_step
        self.data = mujoco.MjData(self.model)
        if stance or self.model.nkey:
            key = self.model.key(stance or 0).id
            mujoco.mj_resetDataKeyframe(self.model, self.data, key)
        mujoco.mj_forward(self.model, self.data)  # xpos, xmat and cvel are 0 until then
        law.place([wheel.placed for wheel in vehicle.wheels])
        self.pull = 0.0
        self._angle = self._wrapped_angle()
        count = len(vehicle.wheels)
        self.forces = WheelForces(np.zeros(count), np.zeros(count), np.zeros(count))
        self._applied = np.zeros((count, 6))
        self.states = self.wheel_states()

    @property
    def time(self) -> float:
        """S since the start."""
        return float(self.data.time)

    @property
    def travel(self) -> float:
        """X of the vehicle's body, m."""
        return float(self.data.xpos[self.vehicle.main_body, 0])

    def step(self, command: NDArray) -> WheelForces:
        """Advance by one time step with the actuators' targets `command`."""
        import mujoco

        mujoco.mj_step1(self.model, self.data)
        self.states = self.wheel_states()
        self.forces = self.law.advance(self.states, self.time_step)
        self._apply(self.forces)
        self.data.ctrl[:] = command
        mujoco.mj_step2(self.model, self.data)
        return self.forces

    def state(self) -> dict[str, NDArray]:
        """All that vehicle and soil remember, as arrays by name; `restore` goes on from it to the bit.

        Raises
        ------
        TypeError
            The law cannot be left: grains.
        """
        import mujoco

        if not isinstance(self.law, Continuable):
            raise TypeError(f"{type(self.law).__name__}: has no state to go on from")
        vehicle = np.empty(mujoco.mj_stateSize(self.model, mujoco.mjtState.mjSTATE_INTEGRATION))
        mujoco.mj_getState(self.model, self.data, vehicle, mujoco.mjtState.mjSTATE_INTEGRATION)
        law = {f"{_LAW}{name}": value for name, value in self.law.state().items()}
        return {"vehicle": vehicle, "angle": self._angle.copy(), "pull": np.array(self.pull)} | law

    def restore(self, state: Mapping[str, NDArray]) -> None:
        """Go on from what `state` gave of the same vehicle on a law of the same soil."""
        import mujoco

        assert isinstance(self.law, Continuable)
        mujoco.mj_setState(self.model, self.data, state["vehicle"], mujoco.mjtState.mjSTATE_INTEGRATION)
        mujoco.mj_fwdPosition(self.model, self.data)
        mujoco.mj_fwdVelocity(self.model, self.data)
        self.pull = float(state["pull"])
        self.law.restore({k[len(_LAW) :]: v for k, v in state.items() if k.startswith(_LAW)})
        self._angle = state["angle"].copy()
        self.states = self.wheel_states()
        self._angle = state["angle"].copy()  # to the bit: looking at the wheels has added rounding

    def wheel_states(self) -> WheelStates:
        """Where the wheels are and how they move, in the order of the vehicle's wheels."""
        data, bodies = self.data, self.vehicle.wheel_bodies
        self._angle = self._angle + _shortest_turn(self._wrapped_angle() - self._angle)
        # `cvel` is turn and velocity at the centre of mass of the whole vehicle: on to the axles.
        turn_x, turn_y, turn_z, velocity_x, velocity_y, velocity_z = data.cvel.take(bodies, axis=0).T
        place = data.xpos.take(bodies, axis=0)
        arm_x, arm_y, arm_z = (place - data.subtree_com[self.vehicle.main_body]).T
        self.sideways = velocity_y + turn_z * arm_x - turn_x * arm_z
        return WheelStates(
            place[:, 0],
            place[:, 2],
            velocity_x + turn_y * arm_z - turn_z * arm_y,
            velocity_z + turn_x * arm_y - turn_y * arm_x,
            self._angle,
            turn_y,
        )

    def _wrapped_angle(self) -> NDArray:
        matrix = self.data.xmat.take(self.vehicle.wheel_bodies, axis=0)
        return np.arctan2(matrix[:, 2], matrix[:, 0])

    def _apply(self, forces: WheelForces) -> None:
        applied, rear = self._applied, self.vehicle.rear_wheels
        applied[:, 0] = forces.force_x
        applied[:, 1] = (
            -SIDE_FRICTION * np.maximum(forces.force_z, 0.0) * np.tanh(self.sideways / _SIDE_CREEP)
        )
        applied[:, 2] = forces.force_z
        applied[:, 4] = forces.torque
        applied[rear, 0] -= self.pull / rear.size
        self.data.xfrc_applied[self.vehicle.wheel_bodies] = applied


def _shortest_turn(angle: NDArray) -> NDArray:
    return (angle + np.pi) % (2 * np.pi) - np.pi
