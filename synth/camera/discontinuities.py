"""Where the motion in a picture breaks off."""

from typing import TYPE_CHECKING

from synth.truth import JUMP_LIMIT

if TYPE_CHECKING:
    import numpy as np

NAMES = ("distance_to_discontinuity", "discontinuity_jump")


def discontinuities(
    u: "np.ndarray",
    v: "np.ndarray",
    implement: "np.ndarray",
    *,
    found: "dict[str, np.ndarray] | None" = None,
) -> "dict[str, np.ndarray]":
    """Distance to the nearest discontinuity, and the jump there, by their names in the truth.

    A discontinuity lies half-way between two pixels, half a pixel from each.

    Parameters
    ----------
    u, v : (H, W) float32
        Displacement, px.
    implement : (H, W) bool
    found : dict, optional
        The result's arrays, (H, W) float32 each, to be overwritten and returned.
    """
    import numpy as np

    from synth.camera import discontinuity_kernels

    if found is None:
        found = {name: np.empty(u.shape, np.float32) for name in NAMES}
    jump, row = np.empty(u.shape, np.float32), np.empty(u.shape, np.int32)
    discontinuity_kernels.find_jumps(u, v, implement.view(np.uint8), JUMP_LIMIT, jump)
    discontinuity_kernels.nearest_in_column(jump, row)
    scratch = np.empty(u.shape, np.int32), np.empty(u.shape, np.float64)
    discontinuity_kernels.nearest_in_picture(row, jump, *scratch, *(found[name] for name in NAMES))
    return found
