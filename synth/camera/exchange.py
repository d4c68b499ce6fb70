"""Grains that come to the glass and leave it: the soil behind moves out of the plane, too."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from synth.camera.streams import Purpose, random_stream

if TYPE_CHECKING:
    from synth.camera.motion import Motion, Placement, Surroundings
    from synth.camera.texture import MicroGrains

_STRIDE = 7919
"""The next grain at a place looks like the one this many further on; a prime, so that all take their turn."""


class Exchanging:
    """A motion in which every frame another grain takes the place of a share of the grains.

    The newcomer has the size of the one that left, but its own albedo, tilt and depth. A placement counts the
    grains that have been at each place before.
    """

    def __init__(self, motion: "Motion", rate: float, seed: int) -> None:
        self._motion, self._rate, self._seed = motion, rate, seed

    def start(self) -> "Placement":
        """Placement in the first frame."""
        placement = self._motion.start()
        return replace(placement, generation=np.zeros(len(placement.x), np.int32))

    def advance(self, placement: "Placement", into: "Placement | None" = None) -> "Placement":
        """Placement one frame later; its arrays may be those of `into`, which are overwritten."""
        moved = self._motion.advance(placement, into)
        assert placement.generation is not None
        stream = random_stream(self._seed, Purpose.EXCHANGE, moved.frame)
        left = stream.random(len(moved.x), dtype=np.float32) < self._rate
        return replace(moved, generation=placement.generation + left)

    def surroundings(
        self, placement: "Placement", second: int, listed: np.ndarray, seen: np.ndarray
    ) -> "Surroundings":
        """Particles around the grains, and how they deform up to the frame `second`."""
        return self._motion.surroundings(placement, second, listed, seen)


def grains_at(grains: "MicroGrains", placement: "Placement") -> "MicroGrains":
    """Micro-grains as they look at a frame."""
    if placement.generation is None or grains.count == 0:
        return grains
    look = (np.arange(grains.count) + _STRIDE * placement.generation.astype(np.int64)) % grains.count
    return replace(
        grains,
        brightness=grains.brightness[look],
        slope_x=grains.slope_x[look],
        slope_y=grains.slope_y[look],
        depth=grains.depth[look],
    )


def still_there(placement: "Placement", other: "Placement") -> "np.ndarray":
    """1 for grains of `placement` that are alive and the same at `other`, else 0; (grain,) uint8."""
    if placement.generation is None or other.generation is None:
        return other.alive
    return other.alive * (placement.generation == other.generation).astype(np.uint8)
