"""What covers a sample or a pixel's centre is the foremost of all discs that hold it, however large."""

import numpy as np
import pytest

from synth.camera.motion import Placement
from synth.camera.samples import in_groups
from synth.camera.texture import MicroGrains
from synth.camera.tiles import TILE, sort_into_tiles
from synth.camera.view import View

HEIGHT, WIDTH, MARGIN = 41, 67, 3
PIXEL = 2e-4


@pytest.fixture(scope="module")
def grains():
    """Micro-grains from a fifth of a sample to many pixels, some of them beyond the picture's edges."""
    generator = np.random.default_rng(12)
    count = 1500
    view = View(WIDTH, HEIGHT, PIXEL, 0.0, 0.0)
    x, z = view.to_world(generator.uniform(-6, WIDTH + 6, count), generator.uniform(-6, HEIGHT + 6, count))
    diameter = PIXEL * np.exp(generator.uniform(np.log(0.05), np.log(12), count))
    diameter[generator.random(count) < 0.9] /= 4
    depth = generator.permutation(count).astype(np.int32) * 2**20
    flat = np.zeros(count, np.float32)
    return view, MicroGrains(x, z, diameter, flat, flat, flat, depth)


def foremost(grains, view, x, y):
    """Number of the foremost grain at rows `y` and columns `x` (px), -1 without.

    Each grain is laid over what was behind it, and compared with all places of its square.
    """
    centre_x, centre_y = view.to_image(grains.x, grains.z)
    found = np.full((y.size, x.size), -1)
    for grain in np.argsort(-grains.depth):
        radius = grains.diameter[grain] / 2 / PIXEL
        across, down = (
            square(places, centre[grain], radius) for places, centre in ((x, centre_x), (y, centre_y))
        )
        inside = np.hypot(x[across] - centre_x[grain], y[down, None] - centre_y[grain]) <= radius
        found[down, across][inside] = grain
    return found


def square(places, centre, radius):
    """Which of rising places a disc may reach, and one more on either side."""
    first, last = np.searchsorted(places, (centre - radius, centre + radius))
    return slice(max(first - 1, 0), last + 1)


@pytest.mark.parametrize("sampling", [4, 5, 6, 8])
def test_the_foremost_disc_covers(taichi, grains, sampling):
    from synth.camera import cover_kernels

    view, grains = grains
    alive = np.ones(grains.count, np.uint8)
    tiled = sort_into_tiles(
        grains, Placement(0, grains.x, grains.z, 0 * grains.x, alive), view, sampling, MARGIN
    )
    shape = HEIGHT + 2 * MARGIN, WIDTH + 2 * MARGIN
    samples, centres = np.empty((*shape, sampling, sampling), np.int32), np.empty(shape, np.int32)
    cover_kernels.cover_by_grains(sampling)(
        tiled.first, tiled.columns, tiled.place, tiled.key, TILE, in_groups(samples), centres
    )
    raster = samples.swapaxes(1, 2).reshape(sampling * shape[0], sampling * shape[1])
    rows, columns = ((np.arange(size) + 0.5) / sampling - 0.5 - MARGIN for size in raster.shape)
    for keys, (x, y) in (
        (raster, (columns, rows)),
        (centres, [np.arange(size) - MARGIN for size in reversed(shape)]),
    ):
        expected = foremost(grains, view, x, y)
        nothing = keys == cover_kernels.NOTHING
        found = np.where(nothing, -1, tiled.grain[np.where(nothing, 0, keys & tiled.index_mask)])
        # Places are rounded to 2^-14 samples: a point on a rim may be on either side of it.
        assert (found != expected).mean() < 2e-4
        assert 0.1 < nothing.mean() < 0.9
