"""Grains that are Gaussians, integrated over every pixel in closed form.

The integral of a Gaussian over a pixel is a product of two differences of error functions, one for x and one
for y; blur by a Gaussian lens only adds to the grain's variance. No sample is taken of anything, so nothing
aliases but what the pixels themselves do, and the pictures are as exact as the motion.
"""

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import erf

if TYPE_CHECKING:
    from synth.scene import AnalyticScene

_LEAST_TILE = 16
"""px; pictures are summed tile by tile, each over the grains that reach it."""
REACH = 5.0
"""Standard deviations to which a grain's light is followed; 6e-7 of it lies further along x or y."""

_ANALYTIC = 3  # first number of every spawn key of this room, so that no other room's stream can be the same


class Purpose(IntEnum):
    """What random numbers are for; a number never changes its meaning."""

    PLACES = 0
    SIZES = 1
    GREYS = 2
    NOISE = 3


def random_stream(seed: int, purpose: Purpose, frame: int = 0) -> np.random.Generator:
    """Stream for a purpose, and a frame where it is drawn anew in each."""
    sequence = np.random.SeedSequence(seed, spawn_key=(_ANALYTIC, int(purpose), frame))
    return np.random.Generator(np.random.PCG64(sequence))


@dataclass(frozen=True, eq=False)
class Grains:
    """Grains in a frame, (grain,) float64 each.

    Attributes
    ----------
    x, y : ndarray
        Centre, px; from the picture's middle where nothing else is said.
    deviation : ndarray
        px, standard deviation of the grain as the lens shows it.
    light : ndarray
        Grey levels times px^2: what all pixels together receive of it, above or below the mean.
    """

    x: np.ndarray
    y: np.ndarray
    deviation: np.ndarray
    light: np.ndarray


def strew(scene: "AnalyticScene") -> Grains:
    """Strew the grains that any frame of a scene shows, uniformly in frame 0."""
    settings = scene.grains
    width, height = (side + 2 * _margin(scene) for side in (scene.camera.width, scene.camera.height))
    # Mean square of a uniform diameter.
    square = (settings.smallest**2 + settings.smallest * settings.largest + settings.largest**2) / 3
    count = round(settings.coverage * width * height / (math.pi / 4 * square))
    places = random_stream(scene.seed_of_pictures, Purpose.PLACES)
    x, y = places.uniform(-0.5, 0.5, count) * width, places.uniform(-0.5, 0.5, count) * height
    sizes = random_stream(scene.seed_of_pictures, Purpose.SIZES)
    diameter = sizes.uniform(settings.smallest, settings.largest, count)
    grey = random_stream(scene.seed_of_pictures, Purpose.GREYS).uniform(-1.0, 1.0, count)
    deviation = np.sqrt((diameter / 4) ** 2 + scene.lens.blur**2)
    area = math.pi / 4 * diameter**2
    # Campbell's theorem: variance of a sum of shots strewn at random; that of the greys is 1/3.
    variance = count / (width * height) * np.mean(area**2 * _shared_light(deviation) ** 2) / 3
    return Grains(x, y, deviation, settings.contrast / math.sqrt(variance) * grey * area)


def light_of(scene: "AnalyticScene", grains: Grains, frame: int) -> np.ndarray:
    """Grey levels (0-255, not rounded or clipped) of a frame before change of light and noise: (H, W)."""
    from threadpoolctl import threadpool_limits

    height, width = scene.camera.height, scene.camera.width
    x, y = scene.motion.place(grains.x, grains.y, frame)
    placed = Grains(x + (width - 1) / 2, y + (height - 1) / 2, grains.deviation, grains.light)
    picture = np.full((height, width), scene.grains.mean)
    tile = max(_LEAST_TILE, round(4 * REACH * float(grains.deviation.max(initial=0.0))))
    # Strips are apart, and each is summed by one thread: threads do not change any sum.
    with threadpool_limits(1, "blas"), ThreadPoolExecutor() as pool:
        list(pool.map(lambda top: _add_strip(picture, placed, top, tile), range(0, height, tile)))
    return picture


def _add_strip(picture: np.ndarray, grains: Grains, top: int, tile: int) -> None:
    """Add the grains' light to the rows from `top` on, tile by tile; grains are in image coordinates."""
    reach = REACH * float(grains.deviation.max(initial=0.0)) + 0.5
    near = np.flatnonzero((grains.y > top - reach) & (grains.y < top + tile - 1 + reach))
    near = near[np.argsort(grains.x[near], kind="stable")]
    edges = np.arange(0, picture.shape[1], tile)
    begins = np.searchsorted(grains.x[near], edges - reach)
    ends = np.searchsorted(grains.x[near], edges + tile - 1 + reach)
    for left, begin, end in zip(edges, begins, ends, strict=True):
        chosen, part = near[begin:end], picture[top : top + tile, left : left + tile]
        deviation = grains.deviation[chosen]
        along_y = _pixel_shares(grains.y[chosen] - top, deviation, part.shape[0])
        along_x = _pixel_shares(grains.x[chosen] - left, deviation, part.shape[1])
        part += (along_y * grains.light[chosen]) @ along_x.T


def expose(scene: "AnalyticScene", light: np.ndarray, frame: int) -> np.ndarray:
    """Picture of a frame from its light: change of light, noise, rounding; (H, W) uint8 or uint16."""
    sensor = scene.sensor
    level = np.array(light, np.float64)
    if frame % 2:
        level = sensor.gain * level + sensor.offset
    if sensor.noise > 0:
        generator = random_stream(scene.seed_of_pictures, Purpose.NOISE, frame)
        level += sensor.noise * generator.standard_normal(level.shape, dtype=np.float32)
    scale, dtype = (1, np.uint8) if sensor.bits == 8 else (257, np.uint16)
    return np.rint(np.clip(level, 0, 255) * scale).astype(dtype)


def _pixel_shares(centre: np.ndarray, deviation: np.ndarray, count: int) -> np.ndarray:
    """Share of each grain's light that falls into pixels 0 to `count` - 1 of a line: (count, grain)."""
    passed = np.arange(count + 1)[:, None] - (centre + 0.5)
    passed *= math.sqrt(0.5) / deviation
    erf(passed, out=passed)
    return np.diff(passed, axis=0) / 2


def _shared_light(deviation: np.ndarray) -> np.ndarray:
    """Integral over all places of the squared share of light in one pixel, along one axis (closed form)."""
    spread = 2 * deviation
    return erf(1 / spread) - spread / math.sqrt(math.pi) * (1 - np.exp(-1 / spread**2))


def _margin(scene: "AnalyticScene") -> float:
    """How far outside the picture a grain of frame 0 can be that some frame shows, px."""
    camera = scene.camera
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, 65) * camera.width, np.linspace(-0.5, 0.5, 65) * camera.height)
    furthest = 0.0
    for frame in range(scene.timing.frame_count):
        came_from = scene.motion.origin(x, y, frame)
        outside = (np.abs(came_from[0]) - camera.width / 2, np.abs(came_from[1]) - camera.height / 2)
        furthest = max(furthest, *(float(side.max()) for side in outside))
    deviation = math.hypot(scene.grains.largest / 4, scene.lens.blur)
    return 1.1 * furthest + REACH * deviation + 2
