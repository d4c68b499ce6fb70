"""Where the motion in a picture breaks off."""

from typing import TYPE_CHECKING

from synth.truth import JUMP_LIMIT

if TYPE_CHECKING:
    import numpy as np


def discontinuities(u: "np.ndarray", v: "np.ndarray", implement: "np.ndarray") -> "dict[str, np.ndarray]":
    """Distance to the nearest discontinuity, and the jump there, by their names in the truth.

    A discontinuity lies half-way between two pixels, half a pixel from each.

    Parameters
    ----------
    u, v : (H, W) float32
        Displacement, px.
    implement : (H, W) bool
    """
    import numpy as np

    from synth.camera import discontinuity_kernels

    jump = np.empty(u.shape, np.float32)
    discontinuity_kernels.find_jumps(u, v, implement.view(np.uint8), JUMP_LIMIT, jump)
    row = np.empty(u.shape, np.int32)
    discontinuity_kernels.nearest_in_column(jump, row)
    distance, nearest_jump = np.empty(u.shape, np.float32), np.empty(u.shape, np.float32)
    scratch = np.empty(u.shape, np.int32), np.empty(u.shape, np.float64)
    discontinuity_kernels.nearest_in_picture(row, jump, *scratch, distance, nearest_jump)
    return {"distance_to_discontinuity": distance, "discontinuity_jump": nearest_jump}
