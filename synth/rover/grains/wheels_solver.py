"""The solver with several rigid wheels in one bin, led along paths from exchange to exchange."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from synth.dem.neighbours import Carried
from synth.dem.solver import Solver
from synth.dem.tool import ToolContacts


@dataclass(frozen=True)
class WheelPlaces:
    """Of every wheel, each array of shape (wheel_count,): m, m and rad, counter-clockwise positive."""

    x: NDArray
    z: NDArray
    angle: NDArray


@dataclass(frozen=True)
class WheelLoads:
    """Mean force (N/m) and moment about the axle (N) that grains put on every wheel, per metre of width."""

    force_x: NDArray
    force_z: NDArray
    moment: NDArray


@dataclass
class WheelsSolver(Solver):
    """Grains among wheels.

    Parameters
    ----------
    radius : tuple of float
        Of every wheel, m.
    places : WheelPlaces
        Where they start.
    """

    radius: tuple[float, ...] = ()
    places: WheelPlaces = field(default_factory=lambda: WheelPlaces(np.zeros(0), np.zeros(0), np.zeros(0)))

    def __post_init__(self) -> None:
        self._speed, self._has_wheels = 0.0, False
        super().__post_init__()
        from synth.rover.grains import wheel_kernels

        self._layout = replace(self._layout, kernels=wheel_kernels)
        self._tool = self._array(self._rows(np.zeros((3, len(self.radius)))).ravel())
        parts = np.zeros((len(self.radius), 6))
        parts[:, wheel_kernels.PART_RADIUS] = self.radius
        self._parts = self._array(parts)
        self._has_wheels = True

    def lead(self, places: WheelPlaces, steps: int) -> WheelLoads:
        """Lead the wheels straight and evenly to other places in so many time steps.

        Returns
        -------
        WheelLoads
            Means over the time that it took.
        """
        from synth.dem import kernels as k

        duration = steps * self.time_step
        was, to = (np.stack([one.x, one.z, one.angle]) for one in (self.places, places))
        velocity = (to - was) / duration
        self._speed = float((np.hypot(*velocity[:2]) + np.abs(velocity[2]) * np.array(self.radius)).max())
        self._tool.from_numpy(self._rows(velocity).ravel())
        self.advance(steps)
        rows = self._tool.to_numpy().reshape(-1, k.TOOL_SIZE)
        self.places = WheelPlaces(*rows[:, [k.TOOL_X, k.TOOL_Z, k.TOOL_ANGLE]].T)
        return WheelLoads(*(rows[:, [k.TOOL_PX, k.TOOL_PZ, k.TOOL_PM]].T / duration))

    def _rows(self, velocity: NDArray) -> NDArray:
        """Entries of `tool`, a row a wheel, no impulse yet."""
        from synth.dem import kernels as k

        rows = np.zeros((len(self.radius), k.TOOL_SIZE))
        rows[:, k.TOOL_X], rows[:, k.TOOL_Z], rows[:, k.TOOL_ANGLE] = (
            self.places.x,
            self.places.z,
            self.places.angle,
        )
        rows[:, k.TOOL_VX], rows[:, k.TOOL_VZ], rows[:, k.TOOL_SPIN] = velocity
        return rows

    def _now(self) -> NDArray:
        """Where the axles are, shape (wheel_count, 2), m."""
        from synth.dem import kernels as k

        if not self._has_wheels:  # on the device, yet
            return np.stack([self.places.x, self.places.z], axis=1)
        return self._tool.to_numpy().reshape(-1, k.TOOL_SIZE)[:, [k.TOOL_X, k.TOOL_Z]]

    def _of_tool(self) -> tuple[float, float]:
        return float(np.hypot(*(self._now() - self._listed_places).T).max()), self._speed

    def _list_tool_contacts(self, position: NDArray) -> None:
        self._listed_places = self._now()
        old = self._tool_contacts
        new = wheel_contacts(position, self.grains.radius, self._listed_places, self.radius, self._skin)
        memory = Carried.between(old.keys, new.keys).carry(self._tool_memory.to_numpy())
        self._tool_contacts = new
        self._tool_memory = self._refilled(self._tool_memory, memory)
        self._reaction = self._refilled(self._reaction, np.zeros((new.keys.size, 3)))
        self._node_force = self._refilled(self._node_force, np.zeros((new.keys.size, 4)))


def wheel_contacts(
    position: NDArray, grain_radius: NDArray, axles: NDArray, radius: tuple[float, ...], skin: float
) -> ToolContacts:
    """List the grains whose surfaces are nearer than `skin` (m) to wheels; a wheel is the part of its number.

    Parameters
    ----------
    position : ndarray, shape (2, N)
    grain_radius : ndarray, shape (N,)
    axles : ndarray, shape (wheel_count, 2)
    radius : tuple of float
        Of the wheels.
    """
    offset = position.T[:, None, :] - axles
    gap = np.hypot(offset[..., 0], offset[..., 1]) - grain_radius[:, None] - np.asarray(radius)
    grain, wheel = np.nonzero(gap < skin)
    return ToolContacts.of(grain, wheel, grain_count=grain_radius.size, part_count=len(radius))
