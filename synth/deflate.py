"""Chunks of netCDF-4 (HDF5) variables, compressed without loss and fast: its own shuffle and deflate filters.

HDF5's own filter pipeline deflates with zlib; ISA-L writes the same format several times as fast, and any
reader of HDF5 reads it.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

_LEVEL = 1  # ISA-L's: 0 is hardly faster, higher ones hardly smaller


def deflated_chunk(values: "np.ndarray") -> bytes:
    """The bytes of a chunk under the filters shuffle (bytes of equal weight together) and deflate."""
    import cv2
    import numpy as np
    from isal import isal_zlib

    size = values.dtype.itemsize
    octets = np.ascontiguousarray(values).view(np.uint8).reshape(len(values), -1, size)
    if size == 1:
        return isal_zlib.compress(octets, _LEVEL)
    shuffled = np.empty((size, *octets.shape[:2]), np.uint8)
    cv2.split(octets, list(shuffled))
    return isal_zlib.compress(shuffled, _LEVEL)
