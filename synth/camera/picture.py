"""From what covers the glass to grey levels, in the order of light: grains, lens, pixel, sensor."""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

from scipy.special import erf

from synth.camera.cover import Cover
from synth.camera.streams import Purpose, random_stream
from synth.camera.texture import tone_behind
from synth.camera.tiles import TILE

if TYPE_CHECKING:
    import numpy as np

    from synth.camera.glass import Glass
    from synth.camera.implement_face import ImplementFace
    from synth.camera.motion import Placement
    from synth.camera.texture import MicroGrains
    from synth.scene import Scene

_BLOTCH = 1.0e-3
"""m; size of the marks on the implement's side."""
_BLUR_REACH = 3.5
"""Deviations of the blur: beyond lies less than 0.05 % of the light."""


@dataclass(frozen=True, eq=False)
class Film:
    """Buffers that every frame of a sequence uses again: what a frame needs most memory for.

    Attributes
    ----------
    radiance : (S (H + 2 margin), S (W + 2 margin)) float32
    filtered : (S (H + 2 margin), W) float32
    """

    radiance: "np.ndarray"
    filtered: "np.ndarray"

    @classmethod
    def like(cls, covered: Cover) -> "Film":
        """Buffers for pictures of this size."""
        import numpy as np

        shape = covered.samples.shape
        return cls(np.empty(shape, np.float32), np.empty((shape[0], covered.view.width), np.float32))


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

    from synth.camera import light_kernels

    film = film or Film.like(covered)
    _radiance(scene, grains, placement, covered, film.radiance)
    if glass is not None:
        glass.put_before(scene, covered, film.radiance)
    sampling = covered.sampling
    taps = _lens_and_pixel(scene.lens.blur, sampling)
    start = covered.margin * sampling - (len(taps) - sampling) // 2
    height, width = covered.centres.shape
    picture = np.empty((height, width), np.float32)
    light_kernels.filter_rows(film.radiance, taps, start, sampling, film.filtered)
    light_kernels.filter_columns(film.filtered, taps, start, sampling, picture)
    passed = _vignette(height, width, scene.lens.vignetting)
    return picture * (passed if glass is None else passed * glass.dirt)


def expose(scene: "Scene", light: "np.ndarray", frame: int) -> "np.ndarray":
    """Grey levels of a frame from light: shot and read noise, black level, clipping, quantisation.

    Thousands of electrons a pixel make the shot noise's Poisson distribution as good as normal.
    """
    import numpy as np

    sensor = scene.sensor
    noise = random_stream(scene.seed, Purpose.SENSOR, frame).standard_normal(light.shape, dtype=np.float32)
    electrons = light * np.float32(sensor.full_well)
    electrons += noise * np.sqrt(electrons + np.float32(sensor.read_noise**2))
    level = electrons / np.float32(sensor.full_well) + np.float32(sensor.black_level)
    full_scale = 2**sensor.bits - 1
    dtype = np.uint8 if sensor.bits == 8 else np.uint16
    return np.rint(np.clip(level, 0, 1) * np.float32(full_scale)).astype(dtype)


def _radiance(
    scene: "Scene",
    grains: "MicroGrains",
    placement: "Placement",
    covered: Cover,
    radiance: "np.ndarray",
) -> None:
    """Light of every sample, as a share of full scale, into `radiance`."""
    import numpy as np

    from synth.camera import light_kernels

    tiled, light = covered.tiled, scene.light
    elevation = math.radians(light.elevation)
    face = np.empty((max(len(tiled.grain), 1), 4), np.float32)
    light_kernels.turn_faces(
        tiled.grain,
        tiled.place,
        placement.angle,
        grains.slope_x,
        grains.slope_y,
        grains.brightness,
        light.intensity,
        scene.texture.roundness,
        face,
    )
    light_kernels.grain_radiance(
        covered.samples,
        tiled.columns,
        TILE,
        tiled.place,
        face,
        tiled.index_mask,
        _behind_the_grains(scene, covered),
        covered.sampling,
        light.ambient,
        math.cos(elevation),
        math.sin(elevation),
        radiance,
    )
    if covered.face is not None:
        _light_implement(scene, covered, covered.face, radiance)


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
