"""Which micro-grains lie wholly behind another one: these need not be drawn while they do."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

    from synth.camera.texture import MicroGrains

_CELL = 2.0
"""Mean diameters; side of the cells that grains are looked up in."""
NOBODY = -1


def hiders(grains: "MicroGrains") -> "np.ndarray":
    """The grain that hides each one in the first frame, or `NOBODY`; (grain,) int32.

    It is a hint where to look first, no more: whether it still hides the grain is seen anew in every frame
    (`synth.camera.tile_kernels`). Of several it is the one that the grain has most room behind.
    """
    import numpy as np

    from synth.camera import hiding_kernels

    if grains.count == 0:
        return np.empty(0, np.int32)
    left, bottom = float(grains.x.min()), float(grains.z.min())
    size = _CELL * float(grains.diameter.mean())
    columns = int((float(grains.x.max()) - left) / size) + 1
    rows = int((float(grains.z.max()) - bottom) / size) + 1
    cell = ((grains.z - bottom) / size).astype(np.int32) * columns + ((grains.x - left) / size).astype(np.int32)
    first = np.zeros(columns * rows + 1, np.int32)
    first[1:] = np.cumsum(np.bincount(cell, minlength=columns * rows))
    best = np.full(grains.count, NOBODY, np.int64)
    hiding_kernels.find_hiders(
        grains.x,
        grains.z,
        grains.diameter,
        grains.depth,
        np.argsort(cell, kind="stable").astype(np.int32),
        first,
        hiding_kernels.grid_vector((left, bottom, 1 / size)),
        columns,
        best,
    )
    return best.astype(np.int32)  # the lower half
