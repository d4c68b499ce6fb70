"""Micro-grains in view, sorted by the square tiles of the picture that they touch."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from synth.camera.view import View

if TYPE_CHECKING:
    import numpy as np

    from synth.camera.hiding import Hiders
    from synth.camera.motion import Placement
    from synth.camera.texture import MicroGrains

TILE = 32
"""px; side of a tile. What a tile needs fits a core's cache, and few grains lie in two."""
_BLOCK_COUNT = 64
"""Parts the grains are sorted in, each by one thread: the order in a tile is that of the grains."""
_KEY_BITS = 31


@dataclass(frozen=True, eq=False)
class TiledGrains:
    """Micro-grains as they lie in a picture, tile by tile; one that touches several tiles is in each.

    Attributes
    ----------
    first : (tiles + 1,) int32
        Each tile's first grain; tiles go row by row.
    columns : int
        Tiles in a row.
    place : (n, 3) float32
        Centre along x and y, and radius, in samples; the tile's first sample is at the origin.
    key : (n,) int32
        Depth in the upper bits, place in these arrays in the lower ones: unique, the least is in front.
    grain : (n,) int32
        Which micro-grain it is.
    index_bits : int
        Number of the lower bits.
    """

    first: "np.ndarray"
    columns: int
    place: "np.ndarray"
    key: "np.ndarray"
    grain: "np.ndarray"
    index_bits: int

    @property
    def index_mask(self) -> int:
        """The key's lower bits."""
        return (1 << self.index_bits) - 1


def sort_into_tiles(
    grains: "MicroGrains",
    placement: "Placement",
    view: View,
    sampling: int,
    margin: int,
    *,
    hiders: "Hiders | None" = None,
) -> TiledGrains:
    """Sort the living grains that touch the picture, or its margin, into tiles.

    Parameters
    ----------
    sampling : int
        Samples along each side of a pixel.
    margin : int
        px around the picture.
    hiders : Hiders, optional
        Grains that lie wholly behind theirs are left out.

    Raises
    ------
    ValueError
        More grains than there are keys for.
    """
    import numpy as np

    from synth.camera import tile_kernels

    columns, rows = (-(-(size + 2 * margin) // TILE) for size in (view.width, view.height))
    tiles = columns * rows
    index_bits = (2 * grains.count + 64 * tiles).bit_length()
    shown = placement.alive if hiders is None else hiders.not_hidden(grains, placement, view, index_bits)
    touched, drawn = np.empty(grains.count, np.int32), np.empty(grains.count, np.int32)
    at = (placement.x, placement.z, grains.diameter)
    frame = (tile_kernels.projection.numbers(view.numbers), sampling, margin, TILE, columns, rows)
    tile_kernels.find_tiles(*at, shown, *frame, touched)
    count = np.zeros((_BLOCK_COUNT, tiles + 2), np.int32)
    tile_kernels.count_in_tiles(*at, touched, *frame, count, drawn)
    count, drawn_count = count[:, :tiles], np.ascontiguousarray(count[:, -1])
    ends = np.cumsum(count.T, dtype=np.int64)
    total = int(ends[-1]) if len(ends) else 0
    if total >= 1 << index_bits or index_bits > _KEY_BITS - 5:
        raise ValueError(f"texture: {grains.count} micro-grains are more than one picture can hold")
    start = (ends.reshape(tiles, _BLOCK_COUNT).T - count).astype(np.int32)
    first = np.append(start[0], total).astype(np.int32)
    place = np.empty((total, 3), np.float32)
    key, grain = np.empty(total, np.int32), np.empty(total, np.int32)
    tile_kernels.sort_into_tiles(
        *at, grains.depth, touched, drawn, drawn_count, *frame, index_bits, start, place, key, grain
    )
    return TiledGrains(first, columns, place, key, grain, index_bits)
