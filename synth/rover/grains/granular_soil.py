"""The granular simulator as the soil under a vehicle: called every step, as a wheel-soil law is.

One track of the vehicle stands in a bin, in plane strain; force times width acts on its wheels, and on those
of the other track, its mirror image. By which the tracks differ all the same, they are held together: nothing
else would keep the vehicle from rolling over, for both meet the same force. In every exchange the wheels are
led to where the vehicle has them, and the mean of what the grains did on the way is the force of the
vehicle's next step.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from synth.dem.bed import Bed, contact_law
from synth.dem.contact_law import time_step_of
from synth.dem.run import surface_height
from synth.rover.grains.wheels_solver import WheelPlaces, WheelsSolver
from synth.rover.law.interface import PlacedWheel, WheelForces, WheelStates
from synth.rover.law.response import SoilError
from synth.scene import SoilBinScene

_HOLD, _HOLD_DAMPING = 1e5, 4e3
"""N/m and N s/m: what holds wheels of two tracks together; it adds up to nothing."""
_AT_END = 0.03
"""m of soil that must be left between a wheel and an end wall."""


class GranularSoil:
    """A `WheelSoilLaw` that simulates the grains.

    Parameters
    ----------
    scene : SoilBinScene
        Its bin, soil and contacts; `drive.start` is where the rearmost axle begins. Its implement, timing and
        camera are not used.
    bed : Bed
        Of that scene; `reset` takes it anew.

    Attributes
    ----------
    surface : float
        Height of the levelled bed's surface above the lowest rim at the start, m: what sinkages are short of.
    """

    def __init__(self, scene: SoilBinScene, bed: Bed) -> None:
        self._scene, self._bed = scene, bed
        self._solver: WheelsSolver | None = None
        self.surface = 0.0

    def place(self, wheels: Sequence[PlacedWheel]) -> None:
        """Take the wheels of a vehicle whose tracks mirror one another.

        Raises
        ------
        SoilError
            There is none, or the tracks' wheels differ.
        """
        tracks: dict[str, list[int]] = {}
        for index, wheel in enumerate(wheels):
            tracks.setdefault(wheel.track, []).append(index)
        sizes = {tuple((wheels[k].radius, wheels[k].width) for k in track) for track in tracks.values()}
        if len(sizes) != 1:
            raise SoilError("wheels: those of every track have to be alike, and at least one is needed")
        self._tracks = np.array(list(tracks.values()))
        self._radius = tuple(wheels[k].radius for k in self._tracks[0])
        self._width = np.array([wheels[k].width for k in self._tracks[0]])
        self.reset()

    def reset(self) -> None:
        """Begin anew on the levelled bed."""
        self._solver = None

    def advance(self, states: WheelStates, time_step: float) -> WheelForces:
        """See `WheelSoilLaw`; the states of the tracks are averaged.

        Raises
        ------
        SoilError
            A wheel comes to an end of the bin.
        """
        x, z, angle = (one[self._tracks].mean(axis=0) for one in (states.x, states.z, states.angle))
        if self._solver is None:
            self._solver = self._begin(x, z, angle, time_step)
        steps = round(time_step / self._solver.time_step)
        places = self._in_bin(x, z, angle)
        self._require_inside(places.x)
        loads = self._solver.lead(places, steps)
        forces = (loads.force_x * self._width, loads.force_z * self._width, -loads.moment * self._width)
        force_x, force_z, torque = (self._on_all(one) for one in forces)
        force_x += self._held(states.x, states.velocity_x)
        force_z += self._held(states.z, states.velocity_z)
        return WheelForces(force_x, force_z, torque)

    def rut(self, track: str) -> NDArray:
        """Tops of the grains along the bin, shape (n, 2): x and z of the vehicle, m."""
        if self._solver is None:
            return np.zeros((2, 2))
        grains, apart = self._solver.read_grains(), 2 * self._scene.bed.grain_diameter
        x, z = grains.in_plane
        column = np.floor(x / apart).astype(int)
        tops = np.zeros(column.max() + 1)
        np.maximum.at(tops, column, z + grains.radius)
        along = (np.arange(tops.size) + 0.5) * apart
        seen = tops > 0
        return np.stack([along[seen] - self._shift[0], tops[seen] - self._shift[1]], axis=1)

    @property
    def solver(self) -> WheelsSolver | None:
        """Of the grains; None before the first step."""
        return self._solver

    def _begin(self, x: NDArray, z: NDArray, angle: NDArray, time_step: float) -> WheelsSolver:
        scene, grains = self._scene, self._bed.grains
        law = contact_law(scene)
        largest = time_step_of(grains, law, scene.contact.steps_per_contact)
        along = scene.drive.start - float(x.min())
        up = max(
            _touching(grains.in_plane, grains.radius, float(at) + along, radius) - float(height)
            for at, height, radius in zip(x, z, self._radius, strict=True)
        )
        self._shift = along, up
        lowest = float((z - np.array(self._radius)).min())
        self.surface = surface_height(grains, scene.bed.grain_diameter) - up - lowest
        return WheelsSolver(
            grains,
            law,
            scene.bed.width,
            time_step / np.ceil(time_step / largest),
            gravity=(0.0, -scene.bed.gravity),
            radius=self._radius,
            places=self._in_bin(x, z, angle),
        )

    def _in_bin(self, x: NDArray, z: NDArray, angle: NDArray) -> WheelPlaces:
        along, up = self._shift
        return WheelPlaces(x + along, z + up, -angle)

    def _require_inside(self, x: NDArray) -> None:
        room = np.array(self._radius) + _AT_END
        if (x < room).any() or (x > self._scene.bed.width - room).any():
            raise SoilError(
                f"bed.width = {self._scene.bed.width:g} m: a wheel came to an end of the bin, "
                f"x = {x.min():.2f} to {x.max():.2f} m; a longer bin is needed"
            )

    def _held(self, place: NDArray, velocity: NDArray) -> NDArray:
        """Force on all wheels by which the tracks are held together, N."""
        apart, parting = (one - self._on_all(one[self._tracks].mean(axis=0)) for one in (place, velocity))
        return -_HOLD * apart - _HOLD_DAMPING * parting

    def _on_all(self, values: NDArray) -> NDArray:
        spread = np.empty(self._tracks.size)
        spread[self._tracks] = values
        return spread


def _touching(position: NDArray, grain_radius: NDArray, x: float, radius: float) -> float:
    """Height of the axle of a wheel at `x` that just touches the grains from above, m."""
    reach = grain_radius + radius
    beside = position[0] - x
    below = np.abs(beside) < reach
    return float((position[1][below] + np.sqrt(reach[below] ** 2 - beside[below] ** 2)).max())
