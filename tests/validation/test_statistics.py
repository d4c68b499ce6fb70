"""Intervals cover what they should, and differences are told only where there are any."""

import numpy as np
import pytest

from validation.statistics import StatisticsError, block_bootstrap, holm, paired_differences


def experiment(random, realisations=8, pairs=40, memory=0.6):
    """Errors around 1 px: each realisation has its own level, and frames remember the former one."""
    found = []
    for _ in range(realisations):
        noise = random.normal(0, 0.1, pairs)
        for k in range(1, pairs):
            noise[k] = memory * noise[k - 1] + np.sqrt(1 - memory**2) * noise[k]
        found.append(1.0 + random.normal(0, 0.1) + noise)
    return found


def test_interval_covers_the_truth():
    covered = 0
    for seed in range(200):
        interval = block_bootstrap(experiment(np.random.default_rng(seed)), block_length=8)
        covered += interval.low <= 1.0 <= interval.high
    assert 0.92 <= covered / 200 <= 0.98


def test_pixels_would_be_too_sure():
    # Drawing frames one by one, of one realisation, ignores that they remember each other.
    frames = experiment(np.random.default_rng(3), realisations=1, pairs=400, memory=0.9)
    one_by_one, blocks = (block_bootstrap(frames, block_length=length) for length in (1, 40))
    assert blocks.high - blocks.low > 2 * (one_by_one.high - one_by_one.low)


def test_counts_and_missing_numbers():
    interval = block_bootstrap([np.array([1.0, np.nan, 3.0]), np.full(3, np.nan)], block_length=1)
    assert (interval.value, interval.realisation_count, interval.pair_count) == (2.0, 1, 2)


def test_one_block_has_no_interval():
    interval = block_bootstrap([np.array([1.0, 2.0])], block_length=5)
    assert interval.value == 1.5 and np.isnan([interval.low, interval.high]).all()


def test_refuses():
    with pytest.raises(StatisticsError, match="no picture pair"):
        block_bootstrap([np.array([np.nan])], block_length=1)
    with pytest.raises(StatisticsError, match="block_length: 0"):
        block_bootstrap([np.ones(3)], block_length=0)
    with pytest.raises(StatisticsError, match="'a' and 'b'"):
        paired_differences({"a": [np.ones(3)], "b": [np.ones(4)]}, block_length=1)


def test_holm():
    assert holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert holm([0.5, 0.9]) == pytest.approx([1.0, 1.0])


def with_own_noise(random, errors, offset=0.0):
    """Another method on the same pictures: the same difficulty, some noise of its own in each realisation."""
    return [one + offset + random.normal(0, 0.02) + random.normal(0, 0.02, one.shape) for one in errors]


def test_tells_a_difference_far_smaller_than_the_scatter():
    random = np.random.default_rng(5)
    errors = experiment(random)
    methods = {"good": with_own_noise(random, errors), "bad": with_own_noise(random, errors, 0.05)}
    (difference,) = paired_differences(methods, block_length=8)
    assert difference.better == "good" and difference.p < 0.05
    assert difference.interval.low < -0.05 < difference.interval.high


def test_seldom_tells_a_difference_where_there_is_none():
    false = 0
    for seed in range(60):
        random = np.random.default_rng(seed)
        errors = experiment(random)
        methods = {name: with_own_noise(random, errors) for name in "abcd"}
        false += any(one.better for one in paired_differences(methods, block_length=8))
    assert false <= 9  # 5 % of 60 are 3; six pairs of four methods share it


def test_same_numbers_same_interval():
    errors = experiment(np.random.default_rng(1))
    assert block_bootstrap(errors, block_length=4) == block_bootstrap(errors, block_length=4)
