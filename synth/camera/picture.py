"""From what covers the glass to grey levels, in the order of light: grains, lens, pixel, sensor."""

import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

from scipy.special import erf

from synth.camera.cover import Cover
from synth.camera.samples import in_groups
from synth.camera.texture import tone_behind
from synth.camera.tiles import TILE
from synth.devices import thread_count

if TYPE_CHECKING:
    import numpy as np
    from threadpoolctl import ThreadpoolController

    from synth.camera.glass import Glass
    from synth.camera.implement_face import ImplementFace
    from synth.camera.motion import Placement
    from synth.camera.texture import MicroGrains
    from synth.scene import Scene

_BLOTCH = 1.0e-3
"""m; size of the marks on the implement's side."""
_ROWS_AT_ONCE = 8
"""Of pixels that are filtered; more waste work on zeros, fewer on starting."""
_BLUR_REACH = 3.5
"""Deviations of the blur: beyond lies less than 0.05 % of the light."""


@dataclass(frozen=True, eq=False)
class Film:
    """Buffers that every frame of a sequence uses again: what a frame needs most memory for.

    Attributes
    ----------
    radiance : (S (H + 2 margin), S (W + 2 margin)) float32
    filtered : (H, S (W + 2 margin)) float32
    faces : (n, 8) float32
        See `light_kernels.grain_radiance`; a picture with more grains than there is room for brings its own.
    """

    radiance: "np.ndarray"
    filtered: "np.ndarray"
    faces: "np.ndarray"

    @classmethod
    def like(cls, covered: Cover) -> "Film":
        """Buffers for pictures of this size with about as many grains."""
        import numpy as np

        rows, columns, sampling, _ = covered.samples.shape
        shape, room = (rows * sampling, columns * sampling), len(covered.tiled.grain) * 5 // 4 + 1
        return cls(
            np.empty(shape, np.float32),
            np.empty((covered.view.height, shape[1]), np.float32),
            np.empty((room, 8), np.float32),
        )


def light_on_sensor(
    scene: "Scene",
    grains: "MicroGrains",
    placement: "Placement",
    covered: Cover,
    *,
    film: Film | None = None,
    glass: "Glass | None" = None,
) -> "np.ndarray":
    """Light of every pixel at an instant, without noise, as a share of full scale: (H, W) float32.

    Lens blur and the integration over the pixel are both convolutions, and are done as one: a Gaussian
    convolved with the pixel's box, applied to the samples. Vignetting and dirt on the lens are so smooth that
    they act on whole pixels.

    Parameters
    ----------
    film : Film, optional
        Buffers to use again.
    glass : Glass, optional
        What is on the glass and the lens; default: nothing.
    """
    import numpy as np

    film = film or Film.like(covered)
    _radiance(scene, grains, placement, covered, film)
    if glass is not None:
        glass.put_before(scene, covered, film.radiance)
    height, width = covered.centres.shape
    weights = _lens_and_pixel(scene.lens.blur, covered.sampling)
    start = covered.margin * covered.sampling - (len(weights) - covered.sampling) // 2
    radiance, half_done = film.radiance[start:], film.filtered
    _filter_rows(radiance, weights, covered.sampling, half_done)
    picture = np.empty((width, height), np.float32)
    _filter_rows(half_done[:, start:].T, weights, covered.sampling, picture)
    picture = picture.T
    passed = _vignette(height, width, scene.lens.vignetting)
    return picture * (passed if glass is None else passed * glass.dirt)


def _filter_rows(fine: "np.ndarray", weights: "np.ndarray", sampling: int, filtered: "np.ndarray") -> None:
    """Sum the rows of samples around every row of pixels, weighted; the first one's start is the first row.

    Some rows at a time are a product with a small matrix, the same one all over; every thread does a part.
    """
    import numpy as np

    count = min(_ROWS_AT_ONCE, len(filtered))
    matrix = np.zeros((count, (count - 1) * sampling + len(weights)), np.float32)
    for row in range(count):
        matrix[row, row * sampling : row * sampling + len(weights)] = weights

    def filter_from(rows: Sequence[int]) -> None:
        for row in rows:
            begin = row * sampling
            np.matmul(matrix, fine[begin : begin + matrix.shape[1]], out=filtered[row : row + count])

    starts, last, parts = range(0, len(filtered) - count, count), len(filtered) - count, thread_count()
    # More threads in a small product would wait more than they work.
    with _linear_algebra().limit(limits=1, user_api="blas"):
        with ThreadPoolExecutor(parts) as threads:
            list(threads.map(filter_from, (starts[part::parts] for part in range(parts))))
        # Not beside the others: it may share rows with the one before, and a product adds to what it zeroed.
        filter_from([last])


@lru_cache(maxsize=1)
def _linear_algebra() -> "ThreadpoolController":
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def _radiance(
    scene: "Scene",
    grains: "MicroGrains",
    placement: "Placement",
    covered: Cover,
    film: Film,
) -> None:
    """Light of every sample, as a share of full scale, into `film.radiance`."""
    import numpy as np

    from synth.camera import light_kernels

    tiled, light = covered.tiled, scene.light
    elevation = math.radians(light.elevation)
    enough = len(film.faces) >= max(len(tiled.grain), 1)
    face = film.faces if enough else np.empty((len(tiled.grain), 8), np.float32)
    height, width = film.radiance.shape
    light_kernels.grain_radiance(covered.sampling)(
        tiled.first,
        tiled.columns,
        tiled.grain,
        tiled.place,
        TILE,
        tiled.index_mask,
        placement.angle,
        grains.slope_x,
        grains.slope_y,
        grains.brightness,
        light.intensity,
        light.ambient,
        scene.texture.roundness,
        (1 - light.ambient) * math.cos(elevation),
        (1 - light.ambient) * math.sin(elevation),
        _behind_the_grains(scene, covered),
        in_groups(covered.samples),
        face,
        film.radiance.reshape(height, width // covered.sampling, covered.sampling),
    )
    if covered.face is not None:
        _light_implement(scene, covered, covered.face, film.radiance)


def _light_implement(scene: "Scene", covered: Cover, face: "ImplementFace", radiance: "np.ndarray") -> None:
    from synth.camera import light_kernels

    light_kernels.implement_radiance(
        covered.samples,
        face.x,
        face.y,
        face.wheel_radius,
        face.angle,
        face.rim,
        covered.view.length_to_image(_BLOTCH),
        light_kernels.projection.numbers(covered.view.numbers),
        covered.sampling,
        covered.margin,
        scene.light.implement,
        face.box(covered.margin),
        radiance,
    )


def _behind_the_grains(scene: "Scene", covered: Cover) -> "np.ndarray":
    """Background, and within the soil its voids, at every pixel of picture and margin; float32."""
    import numpy as np

    soil = np.pad(covered.soil, covered.margin, mode="edge")
    return np.where(soil, np.float32(tone_behind(scene)), np.float32(scene.light.background))


def _lens_and_pixel(blur: float, sampling: int) -> "np.ndarray":
    """Weights of the samples around a pixel: a pixel's box and a Gaussian of `blur` px, convolved."""
    import numpy as np

    reach = math.ceil(_BLUR_REACH * blur * sampling)
    offset = (np.arange(-reach, sampling + reach) + 0.5) / sampling - 0.5
    weight = np.ones(len(offset))
    if blur > 0:
        scale = 1 / (math.sqrt(2) * blur)
        weight = erf((offset + 0.5) * scale) - erf((offset - 0.5) * scale)
    return (weight / weight.sum()).astype(np.float32)


@lru_cache(maxsize=1)
def _vignette(height: int, width: int, loss: float) -> "np.ndarray":
    """Share of the light that arrives: 1 on the axis, 1 - `loss` in the corners, by the squared distance."""
    import numpy as np

    x = np.arange(width, dtype=np.float32) - np.float32((width - 1) / 2)
    y = np.arange(height, dtype=np.float32) - np.float32((height - 1) / 2)
    square = x[None, :] ** 2 + y[:, None] ** 2
    passed = 1 - np.float32(loss) * square / max(float(square.max()), 1.0)
    passed.flags.writeable = False  # every picture of a sequence has the same
    return passed
