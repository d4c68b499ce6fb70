"""What is told everything about the motion finds it, up to a break and in the noise that is expected."""

import cv2
import numpy as np
import pytest

from soft.devices import start_taichi
from synth import picture_pair
from validation.bench.oracle import Oracle

JUMP = 3
"""px; the lower half goes so far to the right."""


@pytest.fixture(scope="module", autouse=True)
def _taichi():
    start_taichi("cpu", 1)


@pytest.fixture(scope="module")
def broken():
    """Soil at rest over soil that slides, pictures of noise 1: pictures, truth."""
    generator = np.random.default_rng(0)
    above, below = (cv2.GaussianBlur(generator.normal(size=(120, 160)), (0, 0), 1.2) * 120 for _ in range(2))
    truth, upper = np.zeros((120, 160, 2)), np.arange(120)[:, None] < 60
    truth[60:, :, 0] = JUMP
    first, second = np.where(upper, above, below), np.where(upper, above, np.roll(below, JUMP, axis=1))
    first, second = (120 + picture + generator.normal(size=picture.shape) for picture in (first, second))
    return first.astype(np.float32), second.astype(np.float32), truth


def errors_of(displacement, truth, places):
    return np.hypot(*(displacement - truth[places[:, 0], places[:, 1]]).T)


@pytest.mark.parametrize("reweigh", [False, True])
def test_windows_end_at_a_break(broken, reweigh):
    first, second, truth = broken
    oracle = Oracle.of(first, second, truth, np.ones(first.shape, bool))
    places = np.argwhere(np.ones((8, 40), bool)).astype(np.int32) + np.array([56, 60], np.int32)
    windows = oracle.windows(places)
    assert errors_of(oracle.measure(windows, reweigh=reweigh), truth, places).max() < 0.1
    assert windows.chosen[:, 1].min() >= 16  # half a disc of either soil


def test_without_knowing_the_break_it_is_missed(broken):
    first, second, truth = broken
    oracle = Oracle.of(first, second, truth, np.ones(first.shape, bool))
    places = np.argwhere(np.ones((2, 120), bool)).astype(np.int32) + np.array([59, 20], np.int32)
    blind = oracle.windows(places, tolerances=[10.0], radii=[16.0])
    assert np.median(errors_of(oracle.measure(blind), truth, places)) > 0.3


def test_it_goes_where_the_pictures_draw_it(broken):
    first, second, truth = broken
    oracle = Oracle.of(first, second, truth, np.ones(first.shape, bool))
    places = np.array([[30, 80], [90, 80]], np.int32)
    windows = oracle.windows(places)
    start = truth[places[:, 0], places[:, 1]] + [[0.5, -0.4]]
    assert oracle.measure(windows, start=start) == pytest.approx(oracle.measure(windows), abs=1e-3)


def test_a_wrong_truth_does_not_come_back(broken):
    """The oracle knows what moves alike; how far is for the pictures to say."""
    first, second, truth = broken
    said = truth + np.array([0.4, 0.2])
    oracle = Oracle.of(first, second, said, np.ones(first.shape, bool))
    places = np.argwhere(np.ones((10, 10), bool)).astype(np.int32) + np.array([20, 60], np.int32)
    found = oracle.measure(oracle.windows(places), reweigh=True)
    assert errors_of(found, truth, places).max() < 0.05


def test_errors_are_as_expected():
    pair = picture_pair("sand_rotation", quick=True, seed=7)
    first, second = pair.first.astype(np.float32), pair.second.astype(np.float32)
    oracle = Oracle.of(first, second, pair.displacement, pair.valid)
    places = np.argwhere(pair.valid)[::97].astype(np.int32)
    windows = oracle.windows(places, radii=[6.0])
    error = errors_of(oracle.measure(windows), pair.displacement, places)
    assert np.sqrt(np.mean(error**2)) == pytest.approx(np.sqrt(np.mean(windows.expected**2)), rel=0.15)


def test_nothing_alike_is_not_measured(broken):
    first, second, truth = broken
    known = np.ones(first.shape, bool)
    known[40:80, 40:80] = False
    known[60, 60] = True
    oracle = Oracle.of(first, second, truth, known)
    windows = oracle.windows(np.array([[60, 60]], np.int32), radii=[4.0, 8.0])
    assert np.isinf(windows.expected).all()
    assert np.isnan(oracle.measure(windows)).all()
