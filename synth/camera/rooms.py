"""Room for frames on their way from who makes them to who writes them, in memory that both can see."""

import mmap
from dataclasses import dataclass

import numpy as np

from synth.camera.shared_arrays import Forms, arrays_in, size_of
from synth.truth import VARIABLES

ROOM_COUNT = 2
"""One that is filled, and one that is written, which takes a fraction of the time."""
_LIGHT = "light"


@dataclass(frozen=True, eq=False)
class Room:
    """Where one frame is put.

    Attributes
    ----------
    number : int
        Which of the rooms it is.
    light : (H, W) float32
        Light of the picture without the sensor's noise, share of full scale.
    truth : dict
        The variables of `synth.truth.VARIABLES`, (H, W) each.
    """

    number: int
    light: np.ndarray
    truth: dict[str, np.ndarray]


def bytes_needed(shape: tuple[int, int]) -> int:
    """Bytes of all rooms for pictures of a shape (H, W)."""
    return ROOM_COUNT * size_of(_forms(shape))


def memory_for(shape: tuple[int, int], file: int = -1) -> mmap.mmap:
    """Memory of `bytes_needed`, of a file or of nobody else; all of it at once, lest frames wait for it."""
    return mmap.mmap(file, bytes_needed(shape), mmap.MAP_SHARED | getattr(mmap, "MAP_POPULATE", 0))


def rooms_in(memory: mmap.mmap, shape: tuple[int, int]) -> list[Room]:
    """Lay the rooms for pictures of a shape (H, W) out in a memory of `bytes_needed`."""
    forms, rooms = _forms(shape), []
    for number in range(ROOM_COUNT):
        arrays = arrays_in(memory, forms, number * size_of(forms))
        rooms.append(Room(number, arrays.pop(_LIGHT), arrays))
    return rooms


def _forms(shape: tuple[int, int]) -> Forms:
    return {_LIGHT: (np.float32, shape)} | {name: (dtype, shape) for name, (dtype, _, _) in VARIABLES.items()}
