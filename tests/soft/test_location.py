"""Intervals against what they promise: 95 % of them hold the true value, whatever the errors' reach."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from soft.location import median_location, mode_locations, weighted_quantiles

TRIALS = 60


def errors(rng, reach, shape=(128, 160)):
    """Errors of 0.1 px that go together over about `reach` px."""
    noise = rng.normal(size=shape)
    if reach == 0:
        return 0.1 * noise
    return 0.1 * 2 * np.sqrt(np.pi) * reach * gaussian_filter(noise, reach, mode="wrap")


def share_that_holds(truth, located):
    return np.mean([one.low <= truth <= one.high for one in located])


@pytest.mark.parametrize("reach", [0, 3])
def test_interval_of_the_median_holds_the_truth(reach):
    rng = np.random.default_rng(1)
    located = [median_location(-7.23 + errors(rng, reach)) for _ in range(TRIALS)]
    # Three standard deviations of a share of 0.95; the largest of several scatters errs to the wide side.
    assert 0.95 - 3 * np.sqrt(0.05 * 0.95 / TRIALS) <= share_that_holds(-7.23, located)
    # And is not wide for nothing: twice what the medians really scatter by, at most.
    scatter = 1.96 * np.std([one.value for one in located])
    assert np.mean([one.high - one.low for one in located]) / 2 < 2 * scatter


@pytest.mark.parametrize("reach", [0, 3])
def test_interval_of_the_mode_holds_the_truth(reach):
    rng = np.random.default_rng(2)
    located = [
        mode_locations(np.dstack([-7.23 + errors(rng, reach), errors(rng, reach)]))[0] for _ in range(TRIALS)
    ]
    assert 0.95 - 3 * np.sqrt(0.05 * 0.95 / TRIALS) <= share_that_holds(-7.23, located)
    scatter = 1.96 * np.std([one.value for one in located])
    assert np.mean([one.high - one.low for one in located]) / 2 < 2 * scatter


def test_interval_where_errors_reach_far():
    """Over 28 px, as if each picture were of 100 independent numbers."""
    rng = np.random.default_rng(5)
    located = [median_location(errors(rng, 8, (256, 320))) for _ in range(60)]
    assert 0.95 - 3 * np.sqrt(0.05 * 0.95 / 60) <= share_that_holds(0.0, located)


def test_errors_that_go_together_make_the_interval_wider():
    rng = np.random.default_rng(3)
    narrow, wide = (median_location(errors(rng, reach)) for reach in (0, 8))
    assert wide.high - wide.low > 5 * (narrow.high - narrow.low)


def test_values_that_are_all_alike():
    located = median_location(np.full((64, 64), 0.25))
    assert (located.value, located.low, located.high) == (0.25, 0.25, 0.25)
    u, v = mode_locations(np.full((64, 64, 2), (0.25, -3.0)))
    assert (u.value, v.value) == pytest.approx((0.25, -3.0), abs=1e-6)
    assert u.high - u.low < 1e-6


def test_weighted_quantiles():
    values = np.random.default_rng(6).normal(size=1000)
    shares = [0.1, 0.5, 0.9]
    assert weighted_quantiles(values, np.full(1000, 0.5), shares) == pytest.approx(
        np.quantile(values, shares), abs=0.02
    )
    # A value of weight 3 is three values.
    assert weighted_quantiles(np.array([5.0, 1.0, 2.0]), np.array([1.0, 3.0, 1.0]), [0.3])[0] == 1.0


def test_nothing_and_too_little():
    field = np.full((64, 64), np.nan)
    assert np.isnan(median_location(field).value)
    assert np.isnan(mode_locations(np.dstack([field, field]))[0].value)
    field[:16, :16] = 1.0
    located = median_location(field)
    assert located.value == 1.0
    assert np.isnan([located.low, located.high]).all(), "four blocks cannot tell"
    u, _ = mode_locations(np.dstack([field, field]))
    assert u.value == pytest.approx(1.0, abs=1e-6)
    assert np.isnan(u.low)


def test_mode_where_most_soil_moves():
    """Resting soil is 30 %; the rest moves by 0.3 to 6 px, in all directions of a flow under a wheel."""
    rng = np.random.default_rng(4)
    field = np.dstack([-7.23 + errors(rng, 3, (192, 256)), 0.1 + errors(rng, 3, (192, 256))])
    y, x = np.mgrid[:192, :256]
    rest = y >= 134
    depth = (134 - y[~rest]) / 134
    field[~rest] += np.stack([0.3 + 5.7 * depth, 2 * depth * np.cos(x[~rest] / 40)], axis=1)
    u, v = mode_locations(field)
    # Soil that moves a little is taken for resting, and pulls: less than a tenth of the paper's 0.34 px.
    assert u.value == pytest.approx(-7.23, abs=0.034)
    assert v.value == pytest.approx(0.1, abs=0.034)
    assert median_location(field[:, :, 0]).value > -7.23 + 1
