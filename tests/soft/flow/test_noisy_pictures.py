"""What `robust-affine` makes of pictures whose noise is as strong as their texture."""

import numpy as np
import pytest

from soft.devices import start_taichi
from soft.flow import estimate_flow

SHAPE = (140, 180)


@pytest.fixture(autouse=True)
def kernels():
    start_taichi("cpu", 1)


def texture(x, y, seed=3):
    """Grey levels of waves of 4 to 9 px in every direction."""
    rng = np.random.default_rng(seed)
    grey = np.zeros(np.broadcast_shapes(x.shape, y.shape))
    for _ in range(60):
        angle, period, phase = rng.uniform((0, 4, 0), (2 * np.pi, 9, 2 * np.pi))
        grey += np.cos(2 * np.pi / period * (np.cos(angle) * x + np.sin(angle) * y) + phase)
    return 128 + 1.2 * grey


def noisy_pair(motion, noise, seed=5):
    """Pictures whose second one shows at x what the first shows at x - motion(x, y), along x."""
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
    rng = np.random.default_rng(seed)
    pictures = texture(x, y), texture(x - motion(x, y), y)
    return [np.clip(picture + rng.normal(0, noise, SHAPE), 0, 255).astype(np.float32) for picture in pictures]


def at_rest():
    return np.zeros((SHAPE[0] // 2, SHAPE[1] // 2, 6), np.float32)


def made_ready(first, second):
    from soft.flow.robust_affine.brightness import PicturePair

    return PicturePair.of(first, second, np.ones(SHAPE, bool)).calmed(first, second, at_rest(), 2)


def test_noise_is_met_only_where_there_is_much():
    clean, noisy = (made_ready(*noisy_pair(lambda x, y: 0 * x, noise)) for noise in (1.0, 8.0))
    assert not clean.noisy and clean.stretch == clean.correlation == 1
    assert noisy.noisy and 1.1 < noisy.stretch < 3 and noisy.correlation > 1


def test_noise_does_not_hold_fits_back():
    from dataclasses import replace

    from soft.flow.robust_affine.windows import Products, Window, fit

    pair = made_ready(*noisy_pair(lambda x, y: 0 * x + 0.5, 8.0))
    models = np.zeros((*SHAPE, 6), np.float32)

    def shift(pair):
        constraints = pair.constrain(models)
        products = Products.of(constraints, constraints.noise(), 3.0)
        return float(np.median(fit(products, Window(20.0, 10), models).at_nodes[4:-4, 4:-4, 0]))

    assert shift(replace(pair, stretch=1.0)) < 0.45
    assert shift(pair) == pytest.approx(0.5, abs=0.04)


def test_windows_do_not_smooth_away_what_lies_below_the_noise_of_a_pixel(monkeypatch):
    from soft.flow.robust_affine import windows

    def motion(x, y):
        return 0.6 * np.sin(2 * np.pi * y / 60)

    first, second = noisy_pair(motion, 8.0)
    truth = motion(*np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)[::-1])

    def wrong():
        found = estimate_flow(first, second, method="robust-affine", threads=1).displacement
        inner = np.s_[20:-20, 20:-20]
        return np.mean(~(np.hypot(found[..., 0] - truth, found[..., 1])[inner] < 0.3))

    judged = wrong()
    monkeypatch.setattr(
        windows, "_bearable", lambda smaller, larger: np.ones(larger.at_nodes.shape[:2], np.uint8)
    )
    assert judged < 0.7 * wrong()


@pytest.mark.parametrize(("smaller", "larger"), [(4.0, 7.0), (12.0, 20.0)])
def test_covariance_of_two_windows(smaller, larger):
    from soft.flow.robust_affine.windows import _shared

    def twiced(sigma):
        t = np.arange(-400, 401)
        g, both = (
            np.exp(-(t**2) / (2 * s * s)) / (2 * np.pi * s * s) ** 0.5 for s in (sigma, 2**0.5 * sigma)
        )
        return 2 * np.outer(g, g) - np.outer(both, both)

    small, large = twiced(smaller), twiced(larger)
    assert _shared(smaller, larger) == pytest.approx((small * large).sum() / (small**2).sum(), rel=1e-4)


def test_products_gathered_keep_their_sums():
    from soft.flow.robust_affine.windows import _gathered

    products = np.zeros((31, 40, 2), np.float32)
    products[4:-4, 4:-4] = np.random.default_rng(1).uniform(0, 1, (23, 32, 2))
    gathered = _gathered(products)
    y, x = np.mgrid[:31, :40]
    assert gathered.shape == (16, 20, 2)
    for weight in (1 + 0 * x, x, y):
        whole = (products * weight[:, :, None]).sum(axis=(0, 1))
        some = (gathered * weight[::2, ::2, None]).sum(axis=(0, 1))
        assert 4 * some == pytest.approx(whole, rel=1e-4)
