"""Grey pictures as PNG (ISO/IEC 15948), without loss and fast: grains hardly compress, whatever is tried."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_UP = 2
"""Filter: every byte less the one above it."""
_LEVEL = 1  # ISA-L's


def png_bytes(picture: "np.ndarray") -> bytes:
    """A PNG file's bytes.

    Parameters
    ----------
    picture : (H, W) uint8 or uint16

    Raises
    ------
    ValueError
        Another data type or shape.
    """
    import struct

    import numpy as np
    from isal import isal_zlib

    if picture.ndim != 2 or picture.dtype not in (np.uint8, np.uint16):
        raise ValueError(f"picture: {picture.dtype} of shape {picture.shape}: grey of 8 or 16 bit is needed")
    bits = 8 * picture.dtype.itemsize
    height, width = picture.shape
    octets = picture.astype(picture.dtype.newbyteorder(">"), order="C", copy=False).view(np.uint8)
    lines = np.empty((height, 1 + octets.shape[1]), np.uint8)
    lines[:, 0] = _UP
    lines[0, 1:] = octets[0]
    np.subtract(octets[1:], octets[:-1], out=lines[1:, 1:])
    # Width, height, bits; grey; the only ways there are to compress and to filter; not interlaced.
    header = struct.pack(">IIBBBBB", width, height, bits, 0, 0, 0, 0)
    parts = ((b"IHDR", header), (b"IDAT", isal_zlib.compress(lines, _LEVEL)), (b"IEND", b""))
    return _SIGNATURE + b"".join(_chunk(kind, data) for kind, data in parts)


def _chunk(kind: bytes, data: bytes) -> bytes:
    import zlib

    return len(data).to_bytes(4, "big") + kind + data + zlib.crc32(kind + data).to_bytes(4, "big")
