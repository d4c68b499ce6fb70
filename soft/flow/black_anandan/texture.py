"""Texture of a picture, without shadows and uneven light, which brightness constancy cannot bear.

As in Wedel, Pock, Zach, Bischof and Cremers (2009) and Sun, Roth and Black (2010): the picture less 95 % of
what total variation denoising (Rudin, Osher, Fatemi 1992) leaves of it.
"""

import numpy as np

_SHARE = 0.95
_THETA = 1 / 8
"""Smoothing, for grey levels from -1 to 1."""
_STEP = 0.249
"""Of the dual field over theta; below 1/4 it converges."""
_ITERATIONS = 100


def texture(picture: np.ndarray, span: float) -> np.ndarray:
    """Texture of (H, W) float32 grey levels; `span`, that of both pictures, is what -1 to 1 stands for.

    Nothing is taken from the whole picture: beyond a mask the two may hold different things.
    """
    from soft.flow.black_anandan import texture_kernels as kernels

    scaled = picture * np.float32(2 / span)
    dual, structure = np.zeros((*picture.shape, 2), np.float32), np.empty_like(scaled)
    for _ in range(_ITERATIONS):
        kernels.primal(scaled, dual, _THETA, structure)
        kernels.ascend(structure, _STEP / _THETA, dual)
    return picture - np.float32(_SHARE * span / 2) * structure
