"""Grains that lie wholly behind another one are left out, and nothing that is seen changes by it."""

from dataclasses import replace

import numpy as np
import pytest

from synth.camera.hiding import Hiders
from synth.camera.motion import Placement
from synth.camera.samples import in_groups
from synth.camera.texture import MicroGrains
from synth.camera.tiles import TILE, sort_into_tiles
from synth.camera.view import View

HEIGHT, WIDTH, MARGIN, SAMPLING = 70, 90, 3, 6
PIXEL = 2e-4


@pytest.fixture(scope="module")
def grains():
    """Micro-grains in several layers, of which the largest are twenty times as large as the smallest."""
    generator = np.random.default_rng(5)
    count = 12_000
    view = View(WIDTH, HEIGHT, PIXEL, 0.0, 0.0)
    x, z = view.to_world(generator.uniform(-6, WIDTH + 6, count), generator.uniform(-6, HEIGHT + 6, count))
    diameter = PIXEL * np.exp(generator.uniform(np.log(0.3), np.log(6), count))
    depth = generator.integers(0, 2**31 - 1, count, dtype=np.int32)
    flat = np.zeros(count, np.float32)
    return view, MicroGrains(x, z, diameter, flat, flat, flat, depth)


def placed(grains, *, x=None, z=None, alive=None):
    alive = np.ones(grains.count, np.uint8) if alive is None else alive
    return Placement(
        0, grains.x if x is None else x, grains.z if z is None else z, np.zeros(grains.count), alive
    )


def seen(grains, placement, view, hiders):
    """Grain at every sample and pixel centre (-1: none), and how many were drawn."""
    from synth.camera import cover_kernels

    tiled = sort_into_tiles(grains, placement, view, SAMPLING, MARGIN, hiders=hiders)
    shape = HEIGHT + 2 * MARGIN, WIDTH + 2 * MARGIN
    samples, centres = np.empty((*shape, SAMPLING, SAMPLING), np.int32), np.empty(shape, np.int32)
    cover_kernels.cover_by_grains(SAMPLING)(
        tiled.first, tiled.columns, tiled.place, tiled.key, TILE, in_groups(samples), centres
    )
    found = []
    for keys in (samples, centres):
        nothing = keys == cover_kernels.NOTHING
        found.append(np.where(nothing, -1, tiled.grain[np.where(nothing, 0, keys & tiled.index_mask)]))
    return *found, len(np.unique(tiled.grain))


def assert_same_seen(grains, placement, view, hiders):
    """Return how many grains are drawn with hiders, and without."""
    *expected, all_drawn = seen(grains, placement, view, None)
    *found, drawn = seen(grains, placement, view, hiders)
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(one, other)
    return drawn, all_drawn


def test_a_pair_is_a_grain_behind_another(taichi, grains):
    _, grains = grains
    pairs = Hiders.of(grains)
    room = (grains.diameter[pairs.hider] - grains.diameter[pairs.grain]) / 2
    away = np.hypot(
        grains.x[pairs.hider] - grains.x[pairs.grain], grains.z[pairs.hider] - grains.z[pairs.grain]
    )
    assert (away < room).all()
    assert (grains.depth[pairs.hider] < grains.depth[pairs.grain]).all()
    for grain in range(0, grains.count, 40):
        away = np.hypot(grains.x - grains.x[grain], grains.z - grains.z[grain])
        behind = (grains.diameter - grains.diameter[grain]) / 2 > away
        assert (grain in pairs.grain) == (behind & (grains.depth < grains.depth[grain])).any()


def test_in_the_first_frame(taichi, grains):
    view, grains = grains
    drawn, all_drawn = assert_same_seen(grains, placed(grains), view, Hiders.of(grains))
    assert drawn < 0.6 * all_drawn


def test_after_the_grains_have_moved_apart(taichi, grains):
    view, grains = grains
    hiders = Hiders.of(grains)
    shift = np.random.default_rng(6).normal(0, PIXEL, (2, grains.count))
    moved = placed(grains, x=grains.x + shift[0], z=grains.z + shift[1])
    drawn, all_drawn = assert_same_seen(grains, moved, view, hiders)
    before, _ = assert_same_seen(grains, placed(grains), view, hiders)
    assert before < drawn < all_drawn


def test_behind_a_lost_grain(taichi, grains):
    view, grains = grains
    alive = (np.random.default_rng(7).random(grains.count) < 0.7).astype(np.uint8)
    assert_same_seen(grains, placed(grains, alive=alive), view, Hiders.of(grains))


def test_after_others_came_to_the_glass(taichi, grains):
    view, grains = grains
    hiders = Hiders.of(grains)
    exchanged = replace(grains, depth=np.random.default_rng(8).permutation(grains.depth))
    assert_same_seen(exchanged, placed(exchanged), view, hiders)


def test_through_a_lens_that_distorts(taichi, grains):
    view, grains = grains
    bent = replace(view, distortion=0.1)
    drawn, all_drawn = assert_same_seen(grains, placed(grains), bent, Hiders.of(grains))
    assert drawn == all_drawn
