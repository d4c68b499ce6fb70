"""How micro-grains move with the simulated particles: three ways behind one small protocol."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from synth.camera.exchange import Exchanging
from synth.camera.particle_field import MovedPoints, ParticleField

if TYPE_CHECKING:
    from synth.camera.texture import MicroGrains
    from synth.recording import Recording
    from synth.scene import Scene


@dataclass(frozen=True)
class Placement:
    """Where the micro-grains are at a frame; shape (grain,) each.

    Attributes
    ----------
    frame : int
    x, z : float64
        Centre, m.
    angle : float64
        Rotation since the first frame, rad, counter-clockwise.
    alive : uint8
        1, or 0 for a grain that was lost where no particle was near.
    generation : int32, optional
        How many grains have been in each one's place before, where grains are exchanged.
    """

    frame: int
    x: "np.ndarray"
    z: "np.ndarray"
    angle: "np.ndarray"
    alive: "np.ndarray"
    generation: "np.ndarray | None" = None


@dataclass(frozen=True)
class Surroundings:
    """The particles around micro-grains, between two frames; shape (listed,) each.

    Attributes
    ----------
    particle : int32
        The particle it moves with (`carried`) or that is nearest (`interpolated`); -1: none.
    strain : float32
        Equivalent shear strain of the particles' motion, from the first to the second frame.
    """

    particle: "np.ndarray"
    strain: "np.ndarray"


class Motion(Protocol):
    """A way for micro-grains to move."""

    def start(self) -> Placement:
        """Placement in the first frame."""
        ...

    def advance(self, placement: Placement, into: Placement | None = None) -> Placement:
        """Placement one frame later; its arrays may be those of `into`, which are overwritten."""
        ...

    def surroundings(
        self, placement: Placement, second: int, listed: "np.ndarray", seen: "np.ndarray"
    ) -> Surroundings:
        """Particles around grains, and how they deform up to the frame `second`.

        Parameters
        ----------
        listed : (listed,) int32
            The grains.
        seen : (seen,) int32
            Places in this list; elsewhere the result means nothing.
        """
        ...


def motion_of(scene: "Scene", recording: "Recording", grains: "MicroGrains") -> Motion:
    """Motion that a scene chooses."""
    motion = _motion_of(scene, recording, grains)
    rate = scene.nuisance.exchange
    return Exchanging(motion, rate, scene.seed_of_pictures) if rate > 0 else motion


def _motion_of(scene: "Scene", recording: "Recording", grains: "MicroGrains") -> Motion:
    if recording.data.sizes["particle"] == 0:
        return OnPlate(recording, grains)
    if scene.texture.motion == "carried":
        return Carried(recording, grains, scene)
    return Interpolated(recording, grains, scene)


class OnPlate:
    """Every grain turns rigidly with the plate, about its pin."""

    def __init__(self, recording: "Recording", grains: "MicroGrains") -> None:
        self._pin = tuple(recording.data[f"implement_{axis}"].values.astype(float) for axis in "xz")
        self._angle = recording.data["implement_angle"].values.astype(float)
        self._grains = grains

    def start(self) -> Placement:
        """Placement in the first frame."""
        return self._at(0)

    def advance(self, placement: Placement, into: Placement | None = None) -> Placement:
        """Placement one frame later, in arrays of its own."""
        return self._at(placement.frame + 1)

    def surroundings(
        self, placement: Placement, second: int, listed: "np.ndarray", seen: "np.ndarray"
    ) -> Surroundings:
        """Nothing: a rigid plate has no particles and no strain."""
        return Surroundings(np.full(len(listed), -1, np.int32), np.zeros(len(listed), np.float32))

    def _at(self, frame: int) -> Placement:
        turn = self._angle[frame] - self._angle[0]
        (pin_x, pin_z), grains = self._pin, self._grains
        off_x, off_z = _turned(grains.x - pin_x[0], grains.z - pin_z[0], turn)
        angle = np.full(grains.count, turn)
        return Placement(frame, pin_x[frame] + off_x, pin_z[frame] + off_z, angle, _all_alive(grains))


class Carried:
    """Every grain moves rigidly with the particle it lies on in the first frame, rotation included."""

    def __init__(self, recording: "Recording", grains: "MicroGrains", scene: "Scene") -> None:
        still = ParticleField(recording, 0, 0, scene)
        every = np.arange(grains.count, dtype=np.int32)
        owner, _ = still.look_around(grains.x, grains.z, every, every)
        self._recording, self._grains, self._owner = recording, grains, owner
        self._scene = scene
        self._alive = (owner >= 0).astype("uint8")

    def start(self) -> Placement:
        """Placement in the first frame."""
        return self._at(0)

    def advance(self, placement: Placement, into: Placement | None = None) -> Placement:
        """Placement one frame later, in arrays of its own."""
        return self._at(placement.frame + 1)

    def surroundings(
        self, placement: Placement, second: int, listed: "np.ndarray", seen: "np.ndarray"
    ) -> Surroundings:
        """Carrying particle, and the strain of the particles around it."""
        strain = ParticleField(self._recording, placement.frame, second, self._scene).strain_of_particles()
        owner = self._owner[listed]
        return Surroundings(owner, strain[owner])

    def _at(self, frame: int) -> Placement:
        grains, owner = self._grains, self._owner
        first_x, first_z, first_angle = self._particles(0)
        x, z, angle = self._particles(frame)
        turn = (angle - first_angle)[owner]
        off_x, off_z = _turned(grains.x - first_x[owner], grains.z - first_z[owner], turn)
        return Placement(frame, x[owner] + off_x, z[owner] + off_z, turn, self._alive)

    def _particles(self, frame: int) -> "list[np.ndarray]":
        names = ("position_x", "position_z", "angle")
        return [self._recording.states(name, frame).astype(np.float64) for name in names]


class Interpolated:
    """Grains follow the smooth field of the particles around, frame by frame, and turn with its rotation.

    Only particles act: the implement does not, and a grain near which there is none any more is lost.
    """

    def __init__(self, recording: "Recording", grains: "MicroGrains", scene: "Scene") -> None:
        self._recording, self._grains, self._scene = recording, grains, scene
        self._latest: tuple[Placement, int, ParticleField] | None = None

    def start(self) -> Placement:
        """Placement in the first frame."""
        grains = self._grains
        return Placement(0, grains.x, grains.z, np.zeros(grains.count), _all_alive(grains))

    def advance(self, placement: Placement, into: Placement | None = None) -> Placement:
        """Placement one frame later, in the arrays of `into` where it is given."""
        field = self._field(placement, placement.frame + 1)
        moved = None if into is None else MovedPoints(into.x, into.z, into.angle, into.alive)
        moved = field.carry(placement.x, placement.z, placement.angle, placement.alive, moved)
        return Placement(placement.frame + 1, moved.x, moved.z, moved.angle, moved.alive)

    def surroundings(
        self, placement: Placement, second: int, listed: "np.ndarray", seen: "np.ndarray"
    ) -> Surroundings:
        """Nearest particle, and the strain at the grain."""
        field = self._field(placement, second)
        return Surroundings(*field.look_around(placement.x, placement.z, listed, seen))

    def _field(self, placement: Placement, second: int) -> ParticleField:
        # Asked for more than once: motion and surroundings.
        latest = self._latest
        if latest is None or latest[0].x is not placement.x or latest[1] != second:
            around = placement.x, placement.z
            field = ParticleField(self._recording, placement.frame, second, self._scene, around=around)
            self._latest = latest = placement, second, field
        return latest[2]


def _turned(x: "np.ndarray", z: "np.ndarray", angle: "np.ndarray") -> tuple["np.ndarray", "np.ndarray"]:
    """Offsets turned counter-clockwise by an angle."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return cosine * x - sine * z, sine * x + cosine * z


def _all_alive(grains: "MicroGrains") -> "np.ndarray":
    return np.ones(grains.count, np.uint8)
