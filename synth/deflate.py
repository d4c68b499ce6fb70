"""Chunks of netCDF-4 (HDF5) variables, compressed without loss and fast: its own shuffle and deflate filters.

HDF5's own filter pipeline spends most of its time on searching repeated strings in the low bytes of
floating-point numbers, where there are none. The same format is written here in parts. After the shuffle,
which puts bytes of equal weight together, the low half of a number's bytes is stored as it is, and the high
half is run-length and Huffman coded. Any reader of HDF5 reads it.
"""

import zlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

_HEADER = b"\x78\x01"
_STORED = 0xFFFF  # bytes in a stored block of deflate, at most


def deflated_chunk(values: "np.ndarray") -> bytes:
    """The bytes of a chunk under the filters shuffle and deflate."""
    import cv2
    import numpy as np

    size = values.dtype.itemsize
    raw: np.ndarray
    octets = np.ascontiguousarray(values).view(np.uint8).reshape(len(values), -1, size)
    raw = np.stack(cv2.split(octets)).reshape(-1) if size > 1 else octets.reshape(-1)
    split = len(raw) // 2 if size == 4 and not _repeats(values) else 0
    check = zlib.adler32(raw.tobytes())
    packer = zlib.compressobj(1, zlib.DEFLATED, -15, 9, zlib.Z_RLE)
    packed = packer.compress(raw[split:].tobytes()) + packer.flush()
    return _HEADER + _stored(raw[:split]) + packed + check.to_bytes(4, "big")


def _repeats(values: "np.ndarray") -> bool:
    """Whether neighbours are mostly equal: then the low bytes are worth compressing, too."""
    import numpy as np

    bits = np.ascontiguousarray(values).view(np.uint32)[::16]
    return bool(np.mean(bits[:, 1:] == bits[:, :-1]) > 0.8)


def _stored(raw: "np.ndarray") -> bytes:
    """Blocks of deflate, none of them the last, that hold bytes as they are (RFC 1951, 3.2.4)."""
    blocks = []
    for begin in range(0, len(raw), _STORED):
        block = raw[begin : begin + _STORED]
        length = len(block)
        blocks += [b"\x00", length.to_bytes(2, "little"), (length ^ 0xFFFF).to_bytes(2, "little")]
        blocks.append(block.tobytes())
    return b"".join(blocks)
