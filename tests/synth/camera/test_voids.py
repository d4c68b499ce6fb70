"""A void between grains is seen by the visible grain whose rim is nearest to the pixel's centre."""

import numpy as np
import pytest

from synth.camera.cover import cover
from synth.camera.pair_truth import filled_voids
from synth.camera.tiles import TILE
from synth.truth import grains_and_motion


@pytest.fixture(scope="module")
def covered(taichi, cases, fields):
    case = cases.case(fields["rest"])
    grains, motion = grains_and_motion(case.recording, case.scene)
    return cover(case.scene, case.recording, grains, motion.start())


def gaps(covered, row, column):
    """From a pixel's centre to the rims of the grains that its samples show, px; by all of these grains."""
    from synth.camera.cover_kernels import IMPLEMENT, NOTHING

    keys = covered.samples[row + covered.margin, column + covered.margin]
    shown = np.unique(keys[(keys != NOTHING) & (keys != IMPLEMENT)]) & covered.tiled.index_mask
    return [rim_gap(covered, row, column, grain) for grain in shown]


def rim_gap(covered, row, column, grain):
    """From a pixel's centre to a grain's rim, px, where both are in one tile."""
    x, y, radius = covered.tiled.place[grain] / covered.sampling
    middle = 0.5 - 0.5 / covered.sampling
    across, down = ((at + covered.margin) % TILE + middle for at in (column, row))
    return np.hypot(across - x, down - y) - radius


def test_no_grain_in_the_pixel_is_nearer(covered):
    from synth.camera.cover_kernels import NOTHING

    filled, off, _ = filled_voids(covered)
    voids = np.argwhere((covered.centres == NOTHING) & covered.soil)
    assert len(voids) > 500
    for row, column in voids:
        found = filled[row, column]
        gap = np.hypot(*off[row, column]) - covered.tiled.place[found, 2] / covered.sampling
        assert gap <= min(gaps(covered, row, column), default=np.inf) + 1e-4


def test_a_pixel_that_shows_a_grain_has_it_and_its_offset(covered):
    from synth.camera.cover_kernels import NOTHING

    filled, off, seen = filled_voids(covered)
    rows, columns = np.nonzero(covered.centres != NOTHING)
    grain = covered.centres[rows, columns] & covered.tiled.index_mask
    assert np.array_equal(filled[rows, columns], grain)
    radius = covered.tiled.place[grain, 2] / covered.sampling
    assert (np.hypot(*off[rows, columns].T) <= radius + 1e-4).all()
    assert np.array_equal(seen, np.unique(filled[filled >= 0]))
