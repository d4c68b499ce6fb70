"""Intervals cover what they should, and differences are told only where there are any."""

import numpy as np
import pytest

from validation.statistics import (
    StatisticsError,
    block_bootstrap,
    holm,
    paired_difference,
    stratified_bootstrap,
)


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
    with pytest.raises(StatisticsError, match="the same pictures"):
        paired_difference([np.ones(3)], [np.ones(4)], block_length=1)


def test_holm():
    assert holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert holm([0.5, 0.9]) == pytest.approx([1.0, 1.0])


def with_own_noise(random, errors, offset=0.0):
    """Another method on the same pictures: the same difficulty, some noise of its own in each realisation."""
    return [one + offset + random.normal(0, 0.02) + random.normal(0, 0.02, one.shape) for one in errors]


def test_tells_a_difference_far_smaller_than_the_scatter():
    random = np.random.default_rng(5)
    errors = experiment(random)
    good, bad = with_own_noise(random, errors), with_own_noise(random, errors, 0.05)
    interval, p = paired_difference(good, bad, block_length=8)
    assert p < 0.01
    assert interval.low < -0.05 < interval.high < 0


def test_seldom_tells_a_difference_where_there_is_none():
    false = 0
    for seed in range(200):
        random = np.random.default_rng(seed)
        errors = experiment(random)
        first, second = (with_own_noise(random, errors) for _ in range(2))
        false += paired_difference(first, second, block_length=8)[1] < 0.05
    assert 2 <= false <= 18  # 5 % of 200 are 10


def test_no_difference_at_all():
    errors = experiment(np.random.default_rng(2))
    assert paired_difference(errors, errors, block_length=8) == (
        block_bootstrap([e - e for e in errors], block_length=8),
        1.0,
    )


def test_same_numbers_same_interval():
    errors = experiment(np.random.default_rng(1))
    assert block_bootstrap(errors, block_length=4) == block_bootstrap(errors, block_length=4)


def scenes_of_two(random, count=8):
    """Two simulations of each of several scenes, which differ far more than simulations of one do."""
    levels = np.linspace(1.0, 3.0, count)
    return [[np.array([level * (1 + random.normal(0, 0.05))]) for _ in range(2)] for level in levels]


def test_interval_over_given_scenes_covers_the_truth():
    covered, widths = 0, []
    for seed in range(200):
        interval, _ = stratified_bootstrap(scenes_of_two(np.random.default_rng(seed)), block_length=1)
        covered += interval.low <= 2.0 <= interval.high
        widths.append(interval.high - interval.low)
    assert 0.91 <= covered / 200 <= 0.985
    assert np.median(widths) < 0.3  # scenes are given: how they differ is no part of it


def test_scenes_told_apart_from_zero_only_where_they_are():
    false = 0
    for seed in range(200):
        random = np.random.default_rng(seed)
        differences = [[random.normal(0, 0.1, 1) for _ in range(2)] for _ in range(8)]
        false += stratified_bootstrap(differences, block_length=1)[1] < 0.05
        assert stratified_bootstrap([[d + 0.5 for d in one] for one in differences], block_length=1)[1] < 0.01
    assert 2 <= false <= 18


def test_scenes_of_one_realisation_have_no_interval():
    interval, p = stratified_bootstrap([[np.array([1.0, 2.0])], [np.array([2.0])]], block_length=4)
    assert interval.value == 1.75 and np.isnan(interval.low) and p == 1
    with pytest.raises(StatisticsError, match="no picture pair"):
        stratified_bootstrap([[np.array([np.nan])]], block_length=1)
