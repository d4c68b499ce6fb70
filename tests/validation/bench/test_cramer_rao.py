"""The Cramér-Rao bound against closed forms, and against the exact fit to many noisy pictures."""

import numpy as np
import pytest
from scipy.ndimage import map_coordinates, spline_filter

from synth import load_scene
from synth.analytic.picture import light_of, strew
from validation.bench.cramer_rao import (
    affine_covariance,
    difference_variance,
    scene_bounds,
    true_slopes,
)

SIDE, MARGIN = 31, 8


@pytest.fixture(scope="module")
def scene():
    found = load_scene("sand_rotation")
    side = SIDE + 2 * MARGIN + 1
    camera = found.camera.model_copy(update={"width": side, "height": side, "scored_radius": None})
    lens = found.lens.model_copy(update={"blur": 1.2})  # what splines follow to a thousandth
    return found.model_copy(update={"camera": camera, "lens": lens})


def test_closed_form():
    slopes = np.zeros((5, 5, 2))
    slopes[:, ::2, 0], slopes[:, 1::2, 1] = 20.0, 10.0  # 15 pixels tell u, 10 tell v
    covariance = affine_covariance(slopes, 4.0, 2, 2)
    assert covariance[0, 0] == pytest.approx(4 / (15 * 20**2))
    assert covariance[3, 3] == pytest.approx(4 / (10 * 10**2))
    assert covariance[1, 1] == pytest.approx(4 / (20**2 * 10 * 4))  # offsets -2, 0, 2 in five rows


def test_noise_of_the_difference():
    sand, dim = load_scene("sand_rotation"), load_scene("sand_low_contrast")
    assert difference_variance(sand) == pytest.approx(2 * (1.5**2 + 1 / 12))
    assert difference_variance(dim) == pytest.approx((8.0**2 + 1 / 12) * (1 + 1 / 0.9**2))


def test_slopes_are_those_of_the_light(scene):
    light = light_of(scene, strew(scene), 0)
    y, x = np.mgrid[10:30, 10:30].astype(float)
    across, down = _slopes(spline_filter(light, 5), x, y)
    slopes = true_slopes(scene)[10:30, 10:30]
    assert across == pytest.approx(slopes[..., 0], abs=0.02 * slopes.std())
    assert down == pytest.approx(slopes[..., 1], abs=0.02 * slopes.std())


def test_the_exact_fit_meets_the_bound(scene):
    noise, rounds, generator = 1.5, 250, np.random.default_rng(1)
    light = light_of(scene, strew(scene), 0)
    middle = light.shape[0] // 2
    window = np.s_[middle - SIDE // 2 : middle + SIDE // 2 + 1]
    covariance = affine_covariance(true_slopes(scene)[window, window], 2 * noise**2, SIDE // 2, SIDE // 2)
    found = np.array(
        [
            _fitted(*(light + noise * generator.standard_normal(light.shape) for _ in range(2)), window)
            for _ in range(rounds)
        ]
    )
    spread = found.var(axis=0) / np.diag(covariance)
    # Of a variance from 250 rounds, 9 % is one standard deviation; of the mean of six, 4 %.
    assert spread == pytest.approx(1, abs=0.27)
    assert spread.mean() == pytest.approx(1, abs=0.12)
    assert np.abs(found.mean(axis=0) / found.std(axis=0)).max() < 4 / np.sqrt(rounds)


def _fitted(first, second, window):
    """Affine motion that makes the difference of two pictures least, by Gauss-Newton."""
    y, x = np.mgrid[window, window].astype(float)
    off_x, off_y = x - x.mean(), y - y.mean()
    before, after = spline_filter(first, 5), spline_filter(second, 5)
    slopes_before, model = _slopes(before, x, y), np.zeros(6)
    for _ in range(2):
        to_x = x + model[0] + model[1] * off_x + model[2] * off_y
        to_y = y + model[3] + model[4] * off_x + model[5] * off_y
        jx, jy = (slopes_before + _slopes(after, to_x, to_y)) / 2
        design = np.stack([jx, jx * off_x, jx * off_y, jy, jy * off_x, jy * off_y], -1).reshape(-1, 6)
        residual = (_read(after, to_x, to_y) - first[window, window]).ravel()
        model -= np.linalg.lstsq(design, residual, rcond=None)[0]
    return model


def _read(spline, x, y):
    return map_coordinates(spline, [y, x], order=5, prefilter=False)


def _slopes(spline, x, y, step=1e-3):
    across = _read(spline, x + step, y) - _read(spline, x - step, y)
    down = _read(spline, x, y + step) - _read(spline, x, y - step)
    return np.stack([across, down]) / (2 * step)


def test_larger_windows_have_lower_bounds(scene):
    middle = scene.camera.height // 2
    small, large = scene_bounds(scene, np.array([[middle, middle]]), (15, 31))
    assert small.rms / large.rms == pytest.approx(31 / 15, rel=0.25)
    assert large.median < large.rms < large.p95
