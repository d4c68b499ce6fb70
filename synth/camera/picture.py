"""From what covers the glass to grey levels, in the order of light: grains, lens, pixel, sensor."""

import math
from typing import TYPE_CHECKING

from scipy.special import erf

from synth.camera.cover import Cover
from synth.camera.streams import Purpose, random_stream

if TYPE_CHECKING:
    import numpy as np

    from synth.camera.texture import MicroGrains
    from synth.scene import Scene

_BLOTCH = 1.0e-3
"""m; size of the marks on the implement's side."""


def take_picture(scene: "Scene", grains: "MicroGrains", covered: Cover, frame: int) -> "np.ndarray":
    """Picture of a frame: (H, W) uint8 or uint16."""
    return expose(scene, light_on_sensor(scene, grains, covered), frame)


def light_on_sensor(scene: "Scene", grains: "MicroGrains", covered: Cover) -> "np.ndarray":
    """Light of every pixel without noise, as a share of full scale: (H, W) float32.

    Lens blur and the integration over the pixel are both convolutions, and are done as one: a Gaussian
    convolved with the pixel's box, applied to the samples. Vignetting varies so slowly that it acts on whole
    pixels.
    """
    import numpy as np

    from synth.camera import kernels

    radiance = _radiance(scene, grains, covered)
    sampling = covered.sampling
    taps = _lens_and_pixel(scene.lens.blur, sampling)
    start = covered.margin * sampling - (len(taps) - sampling) // 2
    height, width = covered.centres.shape
    filtered = np.empty((radiance.shape[0], width), np.float32)
    picture = np.empty((height, width), np.float32)
    kernels.filter_rows(radiance, taps, start, sampling, filtered)
    kernels.filter_columns(filtered, taps, start, sampling, picture)
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


def _radiance(scene: "Scene", grains: "MicroGrains", covered: Cover) -> "np.ndarray":
    """Light of every sample, as a share of full scale; same shape as `covered.samples`, float32."""
    import numpy as np

    from synth.camera import kernels

    radiance = _behind_the_grains(scene, covered)
    placed, face, light = covered.grains, covered.face, scene.light
    elevation = math.radians(light.elevation)
    turned = np.empty((2, grains.count), np.float32)
    kernels.turn_faces(placed.angle, grains.slope_x, grains.slope_y, turned[0], turned[1])
    kernels.grain_radiance(
        covered.samples,
        grains.by_depth,
        placed.x,
        placed.y,
        placed.radius,
        grains.brightness,
        turned[0],
        turned[1],
        covered.sampling,
        covered.margin,
        scene.texture.roundness,
        light.intensity,
        light.ambient,
        math.cos(elevation),
        math.sin(elevation),
        radiance,
    )
    if face is not None:
        blotch = covered.view.length_to_image(_BLOTCH)
        kernels.implement_radiance(
            covered.samples,
            face.x,
            face.y,
            face.wheel_radius,
            face.angle,
            blotch,
            covered.sampling,
            covered.margin,
            light.implement,
            radiance,
        )
    return radiance.astype(np.float32, copy=False)


def _behind_the_grains(scene: "Scene", covered: Cover) -> "np.ndarray":
    """Background, and within the soil its voids, at every sample."""
    import numpy as np

    soil = np.pad(covered.soil, covered.margin, mode="edge")
    behind = np.where(soil, np.float32(scene.light.void), np.float32(scene.light.background))
    return np.repeat(np.repeat(behind, covered.sampling, axis=0), covered.sampling, axis=1)


def _lens_and_pixel(blur: float, sampling: int) -> "np.ndarray":
    """Weights of the samples around a pixel: a pixel's box convolved with a Gaussian of `blur` px."""
    import numpy as np

    reach = math.ceil(4 * blur) + 1 if blur > 0 else 0
    count = sampling * (1 + 2 * reach)
    offset = (np.arange(count) + 0.5) / sampling - 0.5 - reach
    if blur > 0:
        scale = 1 / (math.sqrt(2) * blur)
        weight = erf((offset + 0.5) * scale) - erf((offset - 0.5) * scale)
    else:
        weight = np.ones(count)
    return (weight / weight.sum()).astype(np.float32)


def _vignette(height: int, width: int, loss: float) -> "np.ndarray":
    """Share of the light that arrives: 1 on the axis, 1 - `loss` in the corners, by the squared distance."""
    import numpy as np

    x = np.arange(width, dtype=np.float32) - np.float32((width - 1) / 2)
    y = np.arange(height, dtype=np.float32) - np.float32((height - 1) / 2)
    square = x[None, :] ** 2 + y[:, None] ** 2
    return 1 - np.float32(loss) * square / max(float(square.max()), 1.0)
