"""The response of a method whose response is known."""

import numpy as np
import pytest
import xarray as xr
from scipy.ndimage import gaussian_filter1d

from synth import load_scene
from validation.scoring.modulation import PERIODS, resolved_period, response, response_sums

HEIGHT, WIDTH = 600, 1200


@pytest.fixture(scope="module")
def star():
    """Truth of the scene's formula, and the period of each column."""
    motion = load_scene("sinusoidal_strain").motion
    x, y = np.arange(WIDTH) - (WIDTH - 1) / 2, np.arange(HEIGHT) - (HEIGHT - 1) / 2
    _, moved = motion.place(*np.meshgrid(x, y), 1)
    v = (moved - y[:, np.newaxis]).astype(np.float32)
    truth = xr.Dataset({"v": (("y", "x"), v), "valid": (("y", "x"), np.ones(v.shape, bool))})
    return truth, motion.period(x)


def flow(v):
    return xr.Dataset({"v": (("y", "x"), v)})


def test_the_truth_tells_everything(star):
    truth, periods = star
    shares = response(response_sums(truth, flow(truth["v"].values), periods))
    assert shares == pytest.approx(np.ones(len(PERIODS)))
    assert resolved_period(shares, 0.9) == PERIODS[0]


def test_a_gaussian_window_has_the_gaussian_s_response(star):
    truth, periods = star
    sigma = 8.0
    measured = gaussian_filter1d(truth["v"].values, sigma, axis=0)
    shares = response(response_sums(truth, flow(measured), periods))
    expected = np.exp(-2 * (np.pi * sigma / PERIODS) ** 2)
    assert shares == pytest.approx(expected, abs=0.04)  # a bin holds a range of periods
    exact = np.pi * sigma / np.sqrt(np.log(2) / 2)
    assert resolved_period(shares, 0.5) == pytest.approx(exact, rel=0.04)


def test_what_is_not_measured_tells_nothing(star):
    truth, periods = star
    v = truth["v"].values.copy()
    v[:, :600] = np.nan
    shares = response(response_sums(truth, flow(v), periods))
    assert shares[0] == 0 and shares[-1] == pytest.approx(1)


def test_never_enough():
    assert np.isnan(resolved_period(np.full(len(PERIODS), 0.4), 0.5))
    assert np.isnan(resolved_period(np.full(len(PERIODS), np.nan), 0.5))
