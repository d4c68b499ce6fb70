"""Independent streams of random numbers, one for each purpose, from the scene's seed."""

from enum import IntEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

_CAMERA = 2  # first number of every spawn key of this room, so that no other room's stream can be the same


class Purpose(IntEnum):
    """What random numbers of the camera are for; a number never changes its meaning."""

    PLACES = 0
    SIZES = 1
    LOOKS = 2
    DEPTHS = 3
    SENSOR = 4
    VIBRATION = 5
    FLICKER = 6
    JITTER = 7
    EXCHANGE = 8
    GLASS = 9
    DIRT = 10
    PATCHES = 11


def random_stream(seed: int, purpose: Purpose, frame: int = 0) -> "np.random.Generator":
    """Stream for a purpose; drawing from one never shifts another.

    Parameters
    ----------
    seed : int
        The scene's seed.
    purpose : Purpose
    frame : int
        For what is drawn anew in every frame.
    """
    import numpy as np

    sequence = np.random.SeedSequence(seed, spawn_key=(_CAMERA, int(purpose), frame))
    return np.random.Generator(np.random.PCG64(sequence))
