"""Takes the pictures of a recording, one by one."""

from typing import TYPE_CHECKING

import numpy as np

from synth.camera.cover import Cover, cover
from synth.camera.exchange import grains_at
from synth.camera.glass import Glass
from synth.camera.hiding import Hiders
from synth.camera.nuisance import flicker
from synth.camera.picture import Film, light_on_sensor
from synth.camera.sensor import expose
from synth.camera.shutter import instants
from synth.camera.stages import StageClock

if TYPE_CHECKING:
    from synth.camera.motion import Motion, Placement
    from synth.camera.texture import MicroGrains
    from synth.recording import Recording
    from synth.scene import Scene


class Photographer:
    """Everything that the pictures of a scene have in common. Taichi must have been started."""

    def __init__(
        self,
        scene: "Scene",
        recording: "Recording",
        grains: "MicroGrains",
        motion: "Motion",
        clock: StageClock | None = None,
    ) -> None:
        self._scene, self._recording, self._grains, self._motion = scene, recording, grains, motion
        self._clock = clock or StageClock()
        self._glass = Glass.of(scene, recording)
        self._hiders = Hiders.of(grains)
        self._covered: Cover | None = None
        self._film: Film | None = None

    def take(self, placement: "Placement", previous: "Placement | None") -> tuple[Cover, np.ndarray]:
        """Take the picture of a frame: (H, W) uint8 or uint16, and what covers what at its instant.

        The cover holds until the next picture is taken.
        """
        light = np.empty((self._scene.camera.height, self._scene.camera.width), np.float32)
        covered = self.light(placement, previous, light)
        with self._clock.stage("lighting"):
            return covered, expose(self._scene, light, placement.frame)

    def light(self, placement: "Placement", previous: "Placement | None", light: np.ndarray) -> Cover:
        """Put the light of a frame, without the sensor's noise, into (H, W) float32; share of full scale.

        Returns what covers what at its instant, which holds until the next picture is taken.
        """
        exposure = self._scene.nuisance.exposure
        if exposure == 0:
            taken = self._instant(self._recording, placement, placement.frame)
        else:
            open_for = instants(self._recording, self._motion, placement, previous, exposure)
            lights = [self._instant(states, at, placement.frame) for states, at in open_for]
            taken = np.asarray(np.mean(lights, axis=0, dtype=np.float32))
            self._cover(self._recording, placement, placement.frame)
        assert self._covered is not None
        np.multiply(taken, np.float32(flicker(self._scene, placement.frame)), out=light)
        return self._covered

    def _cover(self, recording: "Recording", placement: "Placement", picture: int) -> "MicroGrains":
        grains = grains_at(self._grains, placement)
        with self._clock.stage("covering"):
            self._covered = cover(
                self._scene,
                recording,
                grains,
                placement,
                hiders=self._hiders,
                reuse=self._covered,
                picture=picture,
            )
        return grains

    def _instant(self, recording: "Recording", placement: "Placement", picture: int) -> np.ndarray:
        grains = self._cover(recording, placement, picture)
        assert self._covered is not None
        self._film = self._film or Film.like(self._covered)
        with self._clock.stage("lighting"):
            return light_on_sensor(
                self._scene, grains, placement, self._covered, film=self._film, glass=self._glass
            )
