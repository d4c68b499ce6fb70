"""Micro-grains of the soil's own size: how many, how large, where, and how each one looks."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from scipy.special import ndtr, ndtri

from synth.camera.patches import patches_at
from synth.camera.streams import Purpose, random_stream
from synth.soil import GrainSizes

if TYPE_CHECKING:
    import numpy as np

    from synth.camera.soil_region import SoilRegion
    from synth.scene import Scene

_SORTING_CELL = 32
"""px; grains are stored cell by cell, so that neighbours on the glass are neighbours in memory."""
DEEPEST = 2**31 - 1
"""Depth of what lies behind every grain."""


@dataclass(frozen=True)
class MicroGrains:
    """Micro-grains in the first frame; shape (grain,) each. Everything but place and angle stays for ever.

    Attributes
    ----------
    x, z : float64
        Centre in the first frame, m.
    diameter : float64
        m.
    brightness : float32
        Albedo times the share of the light that reaches the grain's depth.
    slope_x, slope_y : float32
        Slope of the grain's face along x right and y down of the picture, in the first frame.
    depth : int32
        From the glass: 0 is in front, `DEEPEST` behind everything.
    """

    x: "np.ndarray"
    z: "np.ndarray"
    diameter: "np.ndarray"
    brightness: "np.ndarray"
    slope_x: "np.ndarray"
    slope_y: "np.ndarray"
    depth: "np.ndarray"

    @property
    def count(self) -> int:
        """Number of micro-grains."""
        return len(self.x)


def strew(scene: "Scene", region: "SoilRegion") -> MicroGrains:
    """Strew micro-grains uniformly over a region's bounds and keep those inside the soil."""
    x, z, diameter = _places_and_sizes(scene, region)
    return _with_looks(scene, x, z, diameter, patches_at(scene, region.bounds, x, z))


def draw_diameters(sizes: GrainSizes, count: int, generator: "np.random.Generator") -> "np.ndarray":
    """Draw diameters (m) whose **area** fractions follow the distribution by mass; shape (count,).

    A log-normal distribution by mass, divided by d^2, is a log-normal by number of the same deviation with
    its median lowered by exp(-2 deviation^2); it is drawn between the ends by inverting its distribution.
    """
    import numpy as np

    centre, lower, upper = _by_number(sizes)
    share = generator.uniform(ndtr(lower), ndtr(upper), count)
    return np.exp(centre + sizes.log_deviation * ndtri(share))


def mean_grain_area(sizes: GrainSizes) -> float:
    """Mean area of a grain's disc by number, m2 (closed form of the cut log-normal's second moment)."""
    centre, lower, upper = _by_number(sizes)
    deviation = sizes.log_deviation
    whole = math.exp(2 * centre + 2 * deviation**2)
    kept = ndtr(upper - 2 * deviation) - ndtr(lower - 2 * deviation)
    return math.pi / 4 * whole * float(kept / (ndtr(upper) - ndtr(lower)))


def drawn_sizes(scene: "Scene") -> tuple[GrainSizes, float]:
    """Sizes of the micro-grains that are drawn one by one, and their share of all grains' area.

    Those finer than the texture's `smallest_drawn` are too small to be seen, and there are too many of them.

    Raises
    ------
    ValueError
        Every grain is finer.
    """
    sizes, pixel = scene.soil.grain_sizes, scene.camera.metres_per_pixel
    cut = scene.texture.smallest_drawn * pixel
    if cut <= sizes.smallest:
        return sizes, 1.0
    if cut >= sizes.largest:
        raise ValueError(
            f"texture.smallest_drawn = {scene.texture.smallest_drawn} px: under the soil's largest grain, "
            f"{sizes.largest / pixel:.3g} px, is allowed"
        )
    finest, coarsest, first = (
        ndtr(math.log(size / sizes.median) / sizes.log_deviation)
        for size in (sizes.smallest, sizes.largest, cut)
    )
    share = float((coarsest - first) / (coarsest - finest))
    return sizes.model_copy(update={"smallest": cut}), share


def tone_behind(scene: "Scene") -> float:
    """Light of the soil where no drawn grain lies, as a share of full scale.

    A void, or the finer grains that hide it: these have the mean albedo, face the camera, and lie behind
    every drawn grain, whose shade they are in.
    """
    light, coverage = scene.light, scene.texture.coverage
    _, share = drawn_sizes(scene)
    seen_through = math.exp(-coverage * (1 - share))
    lamps = light.ambient + (1 - light.ambient) * 2 * math.sin(math.radians(light.elevation))
    shaded = (1 - light.shade) ** (coverage * share)
    fines = scene.soil.look.albedo * light.intensity * lamps * shaded
    return seen_through * light.void + (1 - seen_through) * fines


def _by_number(sizes: GrainSizes) -> tuple[float, float, float]:
    """Centre of ln(diameter) by number, and the ends in deviations from it."""
    deviation = sizes.log_deviation
    centre = math.log(sizes.median) - 2 * deviation**2
    lower = (math.log(sizes.smallest) - centre) / deviation
    upper = (math.log(sizes.largest) - centre) / deviation
    return centre, lower, upper


def _places_and_sizes(
    scene: "Scene", region: "SoilRegion"
) -> tuple["np.ndarray", "np.ndarray", "np.ndarray"]:
    import numpy as np

    left, right, bottom, top = region.bounds
    sizes, share = drawn_sizes(scene)
    area = (right - left) * (top - bottom)
    count = round(scene.texture.coverage * share * area / mean_grain_area(sizes))
    places = random_stream(scene.seed_of_pictures, Purpose.PLACES)
    x, z = places.uniform(left, right, count), places.uniform(bottom, top, count)
    diameter = draw_diameters(sizes, count, random_stream(scene.seed_of_pictures, Purpose.SIZES))
    kept = np.flatnonzero(region.contains(x, z))
    order = kept[_cell_order(x[kept], z[kept], diameter[kept], region, scene.camera.metres_per_pixel)]
    return x[order], z[order], diameter[order]


def _cell_order(
    x: "np.ndarray", z: "np.ndarray", diameter: "np.ndarray", region: "SoilRegion", metres_per_pixel: float
) -> "np.ndarray":
    """Order by cells and, in a cell, by size: grains that are drawn alike follow each other."""
    import numpy as np

    left, right, bottom, _ = region.bounds
    cell = _SORTING_CELL * metres_per_pixel
    columns = int((right - left) / cell) + 1
    number = ((z - bottom) / cell).astype(np.int32) * columns + ((x - left) / cell).astype(np.int32)
    return np.lexsort((diameter, number))


def _with_looks(
    scene: "Scene", x: "np.ndarray", z: "np.ndarray", diameter: "np.ndarray", patches: "np.ndarray"
) -> MicroGrains:
    import numpy as np

    count, look, texture = len(x), scene.soil.look, scene.texture
    looks = random_stream(scene.seed_of_pictures, Purpose.LOOKS)
    albedo = np.clip(looks.normal(look.albedo, look.albedo_deviation, count) * patches, 0.02, 1.0)
    slopes = looks.normal(0.0, texture.facet_slope, (2, count)).astype(np.float32)
    depth = random_stream(scene.seed_of_pictures, Purpose.DEPTHS).integers(0, DEEPEST, count, dtype=np.int32)
    # At depth 0..1 of the texture lie 0..coverage layers of grains in front, and each takes its share.
    drawn_coverage = texture.coverage * drawn_sizes(scene)[1]
    light = (1 - scene.light.shade) ** (drawn_coverage / DEEPEST * depth)
    brightness = (albedo * light).astype(np.float32)
    return MicroGrains(x, z, diameter, brightness, slopes[0], slopes[1], depth)
