"""Which micro-grains lie wholly behind another one: these need not be drawn while they do."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

    from synth.camera.motion import Placement
    from synth.camera.texture import MicroGrains
    from synth.camera.view import View

_CELL = 2.0
"""Mean diameters; side of the cells that grains are looked up in."""


@dataclass(frozen=True, eq=False)
class Hiders:
    """Pairs of grains of which one lay wholly behind the other in the first frame; shape (pair,) each.

    They say where to look, no more: whether a pair still is one is seen anew in every frame.

    Attributes
    ----------
    grain, hider : int32
        The one behind, each at most once and in order; and of those in front the one with most room.
    """

    grain: "np.ndarray"
    hider: "np.ndarray"

    @classmethod
    def of(cls, grains: "MicroGrains") -> "Hiders":
        """Find the pairs in the first frame."""
        import numpy as np

        if grains.count == 0:
            return cls(np.empty(0, np.int32), np.empty(0, np.int32))
        best = _with_most_room(grains)
        grain = np.flatnonzero(best >= 0).astype(np.int32)
        return cls(grain, best[grain].astype(np.int32))  # the lower half

    def not_hidden(
        self, grains: "MicroGrains", placement: "Placement", view: "View", index_bits: int
    ) -> "np.ndarray":
        """1 for grains that live and do not lie behind their hider, else 0; (grain,) uint8.

        Parameters
        ----------
        index_bits : int
            Of the depth's, these lower bits do not count: see `synth.camera.tiles.TiledGrains`.
        """
        from synth.camera import hiding_kernels

        shown = placement.alive
        if view.bend == 0:  # a lens that distorts makes no discs of discs
            shown = shown.copy()
            slack = view.metres_per_pixel * hiding_kernels.SLACK
            at = (placement.x, placement.z, grains.diameter, grains.depth, placement.alive)
            hiding_kernels.leave_out_hidden(*at, self.grain, self.hider, slack, index_bits, shown)
        return shown


def _with_most_room(grains: "MicroGrains") -> "np.ndarray":
    """Each grain's hider and the room behind it, as `hiding_kernels.find_hiders` tells; (grain,) int64."""
    import numpy as np

    from synth.camera import hiding_kernels

    left, bottom = float(grains.x.min()), float(grains.z.min())
    size = _CELL * float(grains.diameter.mean())
    columns = int((float(grains.x.max()) - left) / size) + 1
    rows = int((float(grains.z.max()) - bottom) / size) + 1
    row, column = ((at / size).astype(np.int32) for at in (grains.z - bottom, grains.x - left))
    cell = row * columns + column
    first = np.zeros(columns * rows + 1, np.int32)
    first[1:] = np.cumsum(np.bincount(cell, minlength=columns * rows))
    order = np.argsort(cell, kind="stable").astype(np.int32)
    best = np.full(grains.count, -1, np.int64)
    looks = (grains.x, grains.z, grains.diameter, grains.depth)
    grid = hiding_kernels.grid_vector((left, bottom, 1 / size))
    hiding_kernels.find_hiders(*looks, order, first, grid, columns, best)
    return best
