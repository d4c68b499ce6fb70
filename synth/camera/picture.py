"""From what covers the glass to grey levels, in the order of light: grains, lens, pixel, sensor."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from scipy.special import erf

from synth.camera.cover import Cover
from synth.camera.streams import Purpose, random_stream
from synth.camera.tiles import TILE

if TYPE_CHECKING:
    import numpy as np

    from synth.camera.implement_face import ImplementFace
    from synth.camera.motion import Placement
    from synth.camera.texture import MicroGrains
    from synth.scene import Scene

_BLOTCH = 1.0e-3
"""m; size of the marks on the implement's side."""


def take_picture(
    scene: "Scene",
    grains: "MicroGrains",
    placement: "Placement",
    covered: Cover,
    *,
    film: "Film | None" = None,
) -> "np.ndarray":
    """Picture of a frame: (H, W) uint8 or uint16."""
    light = light_on_sensor(scene, grains, placement, covered, film=film)
    return expose(scene, light, placement.frame)


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
) -> "np.ndarray":
    """Light of every pixel without noise, as a share of full scale: (H, W) float32.

    Lens blur and the integration over the pixel are both convolutions, and are done as one: a Gaussian
    convolved with the pixel's box, applied to the samples. Vignetting varies so slowly that it acts on whole
    pixels.

    Parameters
    ----------
    film : Film, optional
        Buffers to use again.
    """
    import numpy as np

    from synth.camera import light_kernels

    film = film or Film.like(covered)
    _radiance(scene, grains, placement, covered, film.radiance)
    sampling = covered.sampling
    across, down = _lens_and_pixel(scene.lens.blur, sampling)
    start = covered.margin * sampling - (len(down) - sampling) // 2
    height, width = covered.centres.shape
    picture = np.empty((height, width), np.float32)
    light_kernels.filter_rows(film.radiance, across, start, sampling, film.filtered)
    light_kernels.filter_columns(film.filtered, down, start, sampling, picture)
    return picture * _vignette(height, width, scene.lens.vignetting)


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


def _light_implement(
    scene: "Scene", covered: Cover, face: "ImplementFace", radiance: "np.ndarray"
) -> None:
    from synth.camera import light_kernels

    light_kernels.implement_radiance(
        covered.samples,
        face.x,
        face.y,
        face.wheel_radius,
        face.angle,
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
    return np.where(soil, np.float32(scene.light.void), np.float32(scene.light.background))


def _lens_and_pixel(blur: float, sampling: int) -> "tuple[np.ndarray, np.ndarray]":
    """Weights of the samples around a pixel: a pixel's box convolved with a Gaussian of `blur` px.

    Along x one row of weights for every row of samples, (S, K), and along y (K,): rows of samples are shifted
    against each other (`synth.camera.cover_kernels`); columns are, too, but a pixel holds all their shifts, so
    that they cancel in the weights along y.
    """
    import numpy as np

    # Beyond 3.5 deviations lies less than a grey level of 16 bits of a picture's contrast.
    reach = math.ceil((3.5 * blur) * sampling) if blur > 0 else 0
    place = np.arange(-reach, sampling + reach) + 0.5
    shift = (np.arange(sampling) + 0.5) / sampling - 0.5
    across = np.stack([_weights((place + s) / sampling - 0.5, blur) for s in shift])
    return across, _weights(place / sampling - 0.5, blur)


def _weights(offset: "np.ndarray", blur: float) -> "np.ndarray":
    """Weights, with sum one, of samples at `offset` px from a pixel's centre; float32."""
    import numpy as np

    weight = np.ones(len(offset))
    if blur > 0:
        scale = 1 / (math.sqrt(2) * blur)
        weight = erf((offset + 0.5) * scale) - erf((offset - 0.5) * scale)
    return (weight / weight.sum()).astype(np.float32)


def _vignette(height: int, width: int, loss: float) -> "np.ndarray":
    """Share of the light that arrives: 1 on the axis, 1 - `loss` in the corners, by the squared distance."""
    import numpy as np

    x = np.arange(width, dtype=np.float32) - np.float32((width - 1) / 2)
    y = np.arange(height, dtype=np.float32) - np.float32((height - 1) / 2)
    square = x[None, :] ** 2 + y[:, None] ** 2
    return 1 - np.float32(loss) * square / max(float(square.max()), 1.0)
