"""Methods that do not say how sure they are get an estimate that follows the noise."""

import numpy as np
import pytest

from soft.flow import BUILT_IN, FlowError, estimate_flow, find_estimator
from soft.flow.plain_uncertainty import plain_uncertainty

PLAIN = sorted(method for method in BUILT_IN if find_estimator(method).effective_window)
INNER = np.s_[20:-20, 20:-20]


@pytest.mark.parametrize("method", sorted(BUILT_IN))
def test_every_built_in_tells_one_sigma_for_each_component(moved, method):
    first, second, _ = moved(shift=(1.3, 0.6))
    field = estimate_flow(first, second, method=method)
    assert field.uncertainty.shape == (*first.shape, 2)
    assert np.array_equal(np.isfinite(field.uncertainty).all(axis=2), field.valid)
    assert (field.uncertainty[field.valid] > 0).all()
    assert estimate_flow(first, second, method=method, uncertainty=False).uncertainty is None
    with pytest.raises(FlowError, match="uncertainty: 1: must be true or false"):
        estimate_flow(first, second, method=method, uncertainty=1)


@pytest.mark.parametrize("forward_backward", [True, False])
@pytest.mark.parametrize("method", PLAIN)
def test_grows_with_noise_about_as_errors_do(moved, method, forward_backward):
    first, second, truth = moved(shift=(1.3, 0.6))
    generator = np.random.default_rng(7)
    told, wrong = [], []
    for noise in (2.0, 6.0, 18.0):
        noisy = [np.clip(p + generator.normal(0, noise, p.shape), 0, 255) for p in (first, second)]
        field = estimate_flow(*noisy, method=method, forward_backward=forward_backward)
        told.append(float(np.nanmedian(field.uncertainty[INNER])))
        wrong.append(float(np.sqrt(np.nanmean(np.square(field.displacement - truth)[INNER]))))
    assert told[0] < 0.6 * told[1] and told[1] < 0.6 * told[2]
    assert all(0.2 < a / b < 5 for a, b in zip(told, wrong, strict=True))


def test_noise_through_one_window_is_the_least_squares_variance():
    """Slopes of 4 grey levels a px along x and 2 along y, noise of 3 in each picture, a square of 15 px."""
    generator = np.random.default_rng(3)
    y, x = np.mgrid[:200, :300]
    texture = 128 + 16 * np.sin(x / 4) + 16 * np.sin(y / 8)
    first, second = ((texture + generator.normal(0, 3, x.shape)).astype(np.float32) for _ in range(2))
    still = np.zeros((*x.shape, 2), np.float32)
    sigma = plain_uncertainty(first, second, still, None, window=15)[30:-30, 30:-30]
    # Noise flattens nothing but adds to the slopes' squares: 3^2 / 2 by central differences.
    for k, square in ((0, 4**2 / 2), (1, 2**2 / 2)):
        expected = np.sqrt(2 * 3**2 / 15**2 / (square + 3**2 / 2))
        assert np.median(sigma[..., k]) == pytest.approx(expected, rel=0.08)


def test_disagreement_counts_half_for_each_way():
    picture = np.random.default_rng(0).uniform(0, 255, (60, 80)).astype(np.float32)
    still, back = np.zeros((60, 80, 2), np.float32), np.zeros((60, 80, 2), np.float32)
    back[..., 1] = 0.4
    sigma = plain_uncertainty(picture, picture, still, back, window=9)
    assert sigma[..., 0].max() < 1e-3
    assert sigma[..., 1] == pytest.approx(0.4 / np.sqrt(2), rel=1e-5)


def test_is_not_told_where_motion_is_not_known():
    picture = np.random.default_rng(0).uniform(0, 255, (60, 80)).astype(np.float32)
    still = np.zeros((60, 80, 2), np.float32)
    still[:20] = np.nan
    sigma = plain_uncertainty(picture, picture, still, None, window=9)
    assert np.isnan(sigma[:20]).all() and np.isfinite(sigma[20:]).all()
