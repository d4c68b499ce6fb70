"""From light to grey levels: the sensor, the last in the order of light."""

from typing import TYPE_CHECKING

import numpy as np

from synth.camera.streams import Purpose, random_stream

if TYPE_CHECKING:
    from synth.scene import Scene


def expose(scene: "Scene", light: np.ndarray, frame: int) -> np.ndarray:
    """Grey levels of a frame from light: shot and read noise, black level, clipping, quantisation.

    Thousands of electrons a pixel make the shot noise's Poisson distribution as good as normal.

    Parameters
    ----------
    light : (H, W) float32
        Share of full scale.

    Returns
    -------
    ndarray
        (H, W) uint8 or uint16.
    """
    sensor = scene.sensor
    stream = random_stream(scene.seed_of_pictures, Purpose.SENSOR, frame)
    noise = stream.standard_normal(light.shape, dtype=np.float32)
    electrons = light * np.float32(sensor.full_well)
    electrons += noise * np.sqrt(electrons + np.float32(sensor.read_noise**2))
    level = electrons / np.float32(sensor.full_well) + np.float32(sensor.black_level)
    full_scale = 2**sensor.bits - 1
    dtype = np.uint8 if sensor.bits == 8 else np.uint16
    return np.rint(np.clip(level, 0, 1) * np.float32(full_scale)).astype(dtype)
