import numpy as np
import pytest

from synth.dem.neighbours import Carried, list_neighbours


def scattered(seed, count=200):
    rng = np.random.default_rng(seed)
    return rng.uniform(0, 0.03, (2, count)), rng.uniform(0.8e-3, 1.2e-3, count)


def of_two_sizes(seed):
    position, radius = scattered(seed)
    return position, radius * np.where(position[0] < 0.01, 4.0, 1.0)


@pytest.mark.parametrize(("position", "radius"), [scattered(0), of_two_sizes(0)])
def test_list_holds_exactly_the_near_pairs_in_order(position, radius):
    listed = list_neighbours(position, radius, 0.5e-3)
    gap = np.hypot(*(position[:, :, None] - position[:, None, :])) - radius[:, None] - radius[None, :]
    expected = np.argwhere(np.triu(gap < 0.5e-3, k=1))
    np.testing.assert_array_equal(listed.pairs.T, expected)


def test_each_grain_finds_its_pairs_and_its_side():
    position, radius = scattered(1)
    listed = list_neighbours(position, radius, 0.5e-3)
    grain, pair = np.zeros((2, listed.ends.size), int)
    for own, ends in zip(listed.pairs, listed.ends, strict=True):
        grain[ends], pair[ends] = own, np.arange(own.size)
    np.testing.assert_array_equal(np.sort(listed.ends, axis=None), np.arange(2 * listed.pairs.shape[1]))
    np.testing.assert_array_equal(grain, np.repeat(np.arange(radius.size), np.diff(listed.first_contact)))
    assert np.all(np.diff(pair)[np.diff(grain) == 0] > 0)


def test_memory_follows_its_pair():
    position, radius = scattered(2)
    old = list_neighbours(position, radius, 0.5e-3)
    memory = np.stack([old.keys * 1.0, -old.keys * 1.0], axis=1)
    moved = position + np.random.default_rng(3).normal(0, 0.3e-3, position.shape)
    new = list_neighbours(moved, radius, 0.5e-3)
    carried = Carried.between(old.keys, new.keys).carry(memory)
    known = np.isin(new.keys, old.keys)
    assert 0.3 < known.mean() < 1
    np.testing.assert_array_equal(carried[:, 0], np.where(known, new.keys, 0))
    np.testing.assert_array_equal(carried[:, 1], -carried[:, 0])


def test_no_pair_at_all():
    position = np.array([[0.0, 1.0], [0.0, 0.0]])
    listed = list_neighbours(position, np.full(2, 1e-3), 1e-4)
    assert listed.pairs.shape == (2, 0)
    assert Carried.between(listed.keys, listed.keys).carry(np.zeros((0, 2))).shape == (0, 2)
