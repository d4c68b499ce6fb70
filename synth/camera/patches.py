"""Patches in the soil, lighter and darker than the rest: it is never mixed evenly, nor equally moist.

They are part of the grains' albedo, so they stay with the soil wherever it moves.
"""

import math
from typing import TYPE_CHECKING

from synth.camera.streams import Purpose, random_stream

if TYPE_CHECKING:
    import numpy as np

    from synth.scene import Scene

_SPACING = 4.0
"""px, of the raster the patches are drawn on; the shortest wave is two of these."""


def patches_at(
    scene: "Scene", bounds: tuple[float, float, float, float], x: "np.ndarray", z: "np.ndarray"
) -> "np.ndarray":
    """Albedo of the soil at places (m) in the first frame / its mean over all places; shape as `x`.

    Parameters
    ----------
    bounds : tuple of float
        Left, right, bottom and top, m: all places lie within.
    """
    import numpy as np
    from scipy.ndimage import map_coordinates

    if scene.texture.patches == 0:
        return np.ones(len(x))
    left, right, bottom, top = bounds
    spacing = _SPACING * scene.camera.metres_per_pixel
    shape = math.ceil((top - bottom) / spacing) + 2, math.ceil((right - left) / spacing) + 2
    stream = random_stream(scene.seed_of_pictures, Purpose.PATCHES)
    field = patch_field(shape, scene.texture.patch_size / spacing, stream)
    at = np.stack([(z - bottom) / spacing, (x - left) / spacing])
    return 1 + scene.texture.patches * map_coordinates(field, at, order=1)


def patch_field(shape: tuple[int, int], longest: float, stream: "np.random.Generator") -> "np.ndarray":
    """Gaussian noise of deviation 1 with as much variance in every octave of waves up to `longest` cells.

    In two dimensions, that is a power that falls with the square of the wave number; it is level below
    1 / `longest`. The deviation is that of the ensemble: one field, of few waves, may have another.
    """
    import numpy as np

    # Twice as large: what is used of it must not meet itself at the other end.
    rows, columns = 2 * shape[0], 2 * shape[1]
    square = np.fft.fftfreq(rows)[:, None] ** 2 + np.fft.rfftfreq(columns)[None, :] ** 2
    power = 1 / (longest**-2 + square)
    whole = np.fft.irfft2(np.fft.rfft2(np.ones((1, 1)), (rows, columns)) * power, (rows, columns))[0, 0]
    noise = np.fft.rfft2(stream.standard_normal((rows, columns)))
    field = np.fft.irfft2(noise * np.sqrt(power / whole), (rows, columns))
    return field[: shape[0], : shape[1]]
