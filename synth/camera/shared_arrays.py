"""Arrays laid out one after the other in memory that several processes share."""

import math
import mmap
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

Forms = Mapping[str, tuple[npt.DTypeLike, tuple[int, ...]]]
"""Data type and shape of arrays by name, in their order."""
_ALIGNED = 64


def size_of(forms: Forms) -> int:
    """Bytes that arrays take together."""
    return sum(_size(*form) for form in forms.values())


def arrays_in(memory: mmap.mmap, forms: Forms, at: int) -> dict[str, np.ndarray]:
    """Arrays by name, the first of which begins at a byte of a memory."""
    arrays = {}
    for name, (dtype, shape) in forms.items():
        arrays[name] = np.frombuffer(memory, dtype, math.prod(shape), at).reshape(shape)
        at += _size(dtype, shape)
    return arrays


def _size(dtype: npt.DTypeLike, shape: tuple[int, ...]) -> int:
    return -(-math.prod(shape) * np.dtype(dtype).itemsize // _ALIGNED) * _ALIGNED
