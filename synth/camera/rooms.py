"""Room for frames on their way from who makes them to who writes them, in memory that both can see."""

import math
import mmap
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from synth.truth import VARIABLES

if TYPE_CHECKING:
    from collections.abc import Iterator

ROOM_COUNT = 2
"""One that is filled, and one that is written, which takes a fraction of the time."""
_LIGHT = "light"
_ALIGNED = 64


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
    return ROOM_COUNT * _room_size(shape)


def memory_for(shape: tuple[int, int], file: int = -1) -> mmap.mmap:
    """Memory of `bytes_needed`, of a file or of nobody else; all of it at once, lest frames wait for it."""
    return mmap.mmap(file, bytes_needed(shape), mmap.MAP_SHARED | getattr(mmap, "MAP_POPULATE", 0))


def rooms_in(memory: mmap.mmap, shape: tuple[int, int]) -> list[Room]:
    """Lay the rooms for pictures of a shape (H, W) out in a memory of `bytes_needed`."""
    size, rooms = _room_size(shape), []
    for number in range(ROOM_COUNT):
        arrays, at = {}, number * size
        for name, dtype in _arrays():
            arrays[name] = np.frombuffer(memory, dtype, math.prod(shape), at).reshape(shape)
            at += _array_size(dtype, shape)
        rooms.append(Room(number, arrays.pop(_LIGHT), arrays))
    return rooms


def _arrays() -> "Iterator[tuple[str, np.dtype]]":
    yield _LIGHT, np.dtype(np.float32)
    for name, (dtype, _, _) in VARIABLES.items():
        yield name, np.dtype(dtype)


def _array_size(dtype: np.dtype, shape: tuple[int, int]) -> int:
    return -(-math.prod(shape) * dtype.itemsize // _ALIGNED) * _ALIGNED


def _room_size(shape: tuple[int, int]) -> int:
    return sum(_array_size(dtype, shape) for _, dtype in _arrays())
