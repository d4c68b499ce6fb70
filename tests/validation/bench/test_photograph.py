"""A moved photograph moves by its formula."""

import cv2
import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from synth.analytic.motion import Rotation, SimpleShear
from validation.bench.photograph import (
    MOTIONS,
    SENSOR_NOISE,
    STOP,
    Signal,
    moved_photograph,
    photograph_cases,
)

REST = SimpleShear(kind="simple_shear", shear=0.0)


@pytest.fixture(scope="module")
def photograph():
    """Dark dots on light ground, a few px each: 520 x 720 px."""
    speckle = np.random.default_rng(0).normal(size=(520, 720))
    return np.clip(160 + 150 * cv2.GaussianBlur(speckle, (0, 0), 2.5), 0, 255).astype(np.uint8)


@pytest.fixture(scope="module")
def signal(photograph):
    return Signal(photograph)


@pytest.mark.parametrize("name", ["rotation", "simple_shear", "sinusoidal_strain"])
def test_second_picture_shows_the_first_one_moved(signal, name):
    moved = moved_photograph(signal, MOTIONS[name], noise=None)
    y, x = np.mgrid[: moved.first.shape[0], : moved.first.shape[1]]
    there = [y + moved.displacement[..., 1], x + moved.displacement[..., 0]]
    inner = moved.valid & (np.minimum(there[0], there[1]) > 8)
    inner &= (there[0] < y.max() - 8) & (there[1] < x.max() - 8)
    found = map_coordinates(moved.second.astype(float), there, order=5)
    assert np.abs(found - moved.first)[inner].max() < 0.1 < 10 < moved.first.std()
    assert np.abs(moved.displacement).max() > 0.4


def test_displacement_is_the_formula(signal):
    moved = moved_photograph(signal, Rotation(kind="rotation", angle=0.02), noise=None)
    height, width = moved.first.shape
    u, v = moved.displacement[0, 0]  # counter-clockwise as seen: the upper left corner goes left and down
    x, y = -(width - 1) / 2, -(height - 1) / 2
    assert u == pytest.approx(x * (np.cos(0.02) - 1) + y * np.sin(0.02), abs=1e-5)
    assert v == pytest.approx(-x * np.sin(0.02) + y * (np.cos(0.02) - 1), abs=1e-5)
    assert u < 0 < v


def test_rest_leaves_nothing_but_noise(signal):
    clean, noisy = moved_photograph(signal, REST, noise=None), moved_photograph(signal, REST)
    assert not clean.displacement.any()
    assert np.array_equal(clean.first, clean.second)
    assert clean.valid.all()
    spread = (noisy.second - noisy.first).std()
    assert spread == pytest.approx(np.sqrt(2 * (SENSOR_NOISE**2 + 1 / 12)), rel=0.03)
    assert np.array_equal(noisy.first, np.rint(noisy.first))
    again = moved_photograph(signal, REST, seed=1)
    assert not np.array_equal(noisy.first, again.first)


def test_signal_holds_nothing_fast(signal):
    from scipy.fft import dctn

    energy = dctn(signal.points, type=2, norm="ortho") ** 2
    down, across = (np.arange(n) / n for n in energy.shape)  # per pixel of the pictures
    fast = np.hypot(down[:, None], across) > STOP
    assert energy[fast].sum() < 1e-12 * energy.sum()


def test_cases_of_a_file(photograph, tmp_path, monkeypatch):
    path = tmp_path / "soil.png"
    cv2.imwrite(str(path), photograph.T)  # upright ones are laid on their side
    sources = photograph_cases(path)
    case = sources[list(MOTIONS).index("shear_band")]()
    assert case.name == "soil, shear_band"
    assert case.first.shape == case.truth.shape[:2] == Signal(photograph).picture_shape
    assert set(case.regions) == {"all", "band", "inside the band"}
    monkeypatch.delenv("SOFTBED_DATA", raising=False)
    assert photograph_cases(None) == []
    with pytest.raises(ValueError, match="no such file"):
        photograph_cases(tmp_path / "none.png")
    path.write_bytes(b"no picture")
    with pytest.raises(ValueError, match="no picture"):
        photograph_cases(path)[0]()


def test_small_photographs_are_refused():
    with pytest.raises(ValueError, match="384 px at least"):
        Signal(np.zeros((300, 800), np.uint8))
