"""`robust-affine` on pictures whose motion is known by formula."""

import numpy as np
import pytest

from soft.flow import FlowError, estimate_flow
from soft.flow.robust_affine import windows

SHAPE = (150, 200)


class Waves:
    """Sums of plane waves of 5 to 50 px: grey levels anywhere, without interpolation."""

    def __init__(self, seed=0, count=150):
        random = np.random.default_rng(seed)
        angle, self.phase = random.uniform(0, 2 * np.pi, (2, count))
        number = 2 * np.pi / np.exp(random.uniform(np.log(5), np.log(50), count))
        self.kx, self.ky = number * np.cos(angle), number * np.sin(angle)
        self.amplitude = 45 * np.sqrt(2 / count)

    def __call__(self, x, y):
        grey = np.full(np.broadcast(x, y).shape, 127.0)
        for kx, ky, phase in zip(self.kx, self.ky, self.phase, strict=True):
            grey += self.amplitude * np.cos(kx * x + ky * y + phase)
        return np.clip(grey, 0, 255).astype(np.float32)


def grid(shape=SHAPE):
    y, x = np.mgrid[: shape[0], : shape[1]].astype(float)
    return x, y


def affine_pair(motion, gradient, *, shape=SHAPE, seed=0):
    """Pictures and true displacement (H, W, 2); `motion` px at the middle, `gradient` (2, 2) px/px."""
    x, y = grid(shape)
    middle = (np.array(shape[::-1]) - 1) / 2
    waves, gradient = Waves(seed), np.asarray(gradient, float)
    offset = np.stack([x, y], -1) - middle
    back = (offset - np.asarray(motion, float)) @ np.linalg.inv(np.eye(2) + gradient).T + middle
    return waves(x, y), waves(back[..., 0], back[..., 1]), np.asarray(motion) + offset @ gradient.T


def errors(field, truth, where=slice(None)):
    return np.hypot(*np.moveaxis(field.displacement - truth, 2, 0))[where]


@pytest.mark.parametrize("preset", ["accurate", "fast"])
def test_an_affine_motion_with_its_gradient(preset):
    gradient = np.array([[0.010, 0.030], [-0.015, -0.020]])  # each entry another: no axis can be swapped
    first, second, truth = affine_pair((2.3, -1.4), gradient)
    field = estimate_flow(first, second, method="robust-affine", preset=preset)
    inner = np.s_[12:-12, 12:-12]
    error = errors(field, truth)[inner]
    assert np.median(error) < 0.01 and np.quantile(error, 0.95) < 0.05
    np.testing.assert_allclose(np.median(field.gradient[inner], axis=(0, 1)), gradient, atol=0.003)


def test_brighter_second_picture_does_not_matter():
    first, second, truth = affine_pair((1.6, 0.7), [[0.0, 0.02], [0.0, 0.0]])
    field = estimate_flow(first, 0.8 * second + 20, method="robust-affine")
    assert np.median(errors(field, truth)[field.valid]) < 0.01


def test_thirty_px_a_frame():
    first, second, truth = affine_pair((30.0, 4.0), np.zeros((2, 2)), shape=(200, 300))
    field = estimate_flow(first, second, method="robust-affine")
    assert field.valid.mean() > 0.8
    assert np.quantile(errors(field, truth)[field.valid], 0.95) < 0.05


def test_what_leaves_the_picture_is_not_valid():
    first, second, _ = affine_pair((6.0, 0.0), np.zeros((2, 2)))
    field = estimate_flow(first, second, method="robust-affine")
    assert not field.valid[:, -5:].any() and field.valid[2:-2, 10:-10].all()


def broken_pair(jump, shape=SHAPE):
    """The upper half moves by + jump / 2, the lower one by - jump / 2, along x."""
    x, y = grid(shape)
    waves = Waves(3)
    u = np.where(y < shape[0] / 2, jump / 2, -jump / 2)
    return waves(x, y), waves(x - u, y), np.stack([u, 0 * u], -1)


def test_a_break_stays_sharp():
    first, second, truth = broken_pair(4.0)
    near = np.s_[SHAPE[0] // 2 - 10 : SHAPE[0] // 2 + 10, 15:-15]
    mended, plain = (
        np.mean(errors(estimate_flow(first, second, method="robust-affine", edges=edges), truth)[near] > 0.3)
        for edges in (True, False)
    )
    assert mended < 0.2 and mended < 0.6 * plain


def test_a_masked_region_does_not_leak():
    first, second, truth = broken_pair(6.0)
    upper = np.zeros(SHAPE, bool)
    upper[: SHAPE[0] // 2] = True
    field = estimate_flow(first, second, method="robust-affine", mask=upper)
    assert not field.valid[SHAPE[0] // 2 :].any()
    rim = np.s_[SHAPE[0] // 2 - 6 : SHAPE[0] // 2, 15:-15]
    assert np.quantile(errors(field, truth)[rim], 0.95) < 0.1


def edged_pair(soil_motion, edge_motion):
    """Soil below a slanting, slightly blurred edge, dark above; where soil is."""
    waves = Waves(seed=7)
    x, y = grid()

    def picture(soil, edge):
        depth = (y - edge[1] - 40 - 0.3 * (x - edge[0])) / np.hypot(1, 0.3)
        share = 0.5 * (1 + np.tanh(depth / 0.7))
        return 12 + share * (waves(x - soil[0], y - soil[1]) - 12), depth

    first, depth = picture((0, 0), (0, 0))
    return first, picture(soil_motion, edge_motion)[0], depth


@pytest.mark.parametrize("edge_motion", [(1.3, 0.4), (-2.0, 1.5)], ids=["free surface", "implement"])
def test_an_edge_that_moves_otherwise_does_not_leak(edge_motion):
    first, second, depth = edged_pair((1.3, 0.4), edge_motion)
    field = estimate_flow(first, second, method="robust-affine", mask=depth > -2)
    off, depth = errors(field, np.array([1.3, 0.4]))[:, 15:-15], depth[:, 15:-15]
    for near in ((depth > 0.5) & (depth < 3), (depth > 3) & (depth < 8)):
        assert np.nanquantile(off[near], 0.95) < 0.1 and np.isfinite(off[near]).mean() > 0.9


def test_uncertainty_covers_the_errors_of_noise():
    first, second, truth = affine_pair((1.3, 0.4), [[0.01, 0.0], [0.0, 0.01]], seed=5)
    random = np.random.default_rng(1)
    noisy = [np.clip(p + random.normal(0, 6, SHAPE), 0, 255) for p in (first, second)]
    field = estimate_flow(*noisy, method="robust-affine")
    z = np.abs((field.displacement - truth) / field.uncertainty)[field.valid]
    # One picture pair holds few independent errors: wide bounds.
    assert 0.5 < np.mean(z < 1) < 0.9 and np.mean(z < 1.96) > 0.85


def test_noise_does_not_draw_motion_to_half_pixels():
    first, second, truth = affine_pair((0.25, -0.25), np.zeros((2, 2)), seed=3)
    random, off = np.random.default_rng(2), []
    for _ in range(6):
        noisy = [np.clip(p + random.normal(0, 6, SHAPE), 0, 255) for p in (first, second)]
        field = estimate_flow(*noisy, method="robust-affine")
        off.append(np.nanmean(field.displacement - truth, axis=(0, 1)))
    # Interpolation makes it (0.021, -0.015) if nothing is done about it.
    assert np.abs(np.mean(off, axis=0)).max() < 0.004


def test_uncertainty_is_large_where_motion_breaks_off():
    first, second, _ = broken_pair(4.0)
    field = estimate_flow(first, second, method="robust-affine")
    near, far = field.uncertainty[SHAPE[0] // 2 - 3, 15:-15, 0], field.uncertainty[30, 15:-15, 0]
    assert np.isfinite(near).mean() > 0.98  # the way back may go astray right at the break
    assert np.nanmedian(near) > 5 * np.median(far)


def test_uncertainty_covers_its_share_of_errors():
    z = []
    for seed in range(4):
        gradient = [[0.01, 0.02], [-0.01, 0.005]]
        first, second, truth = affine_pair((1.3, -0.7), gradient, shape=(240, 320), seed=seed)
        random = np.random.default_rng(seed)
        noisy = [np.clip(picture + random.normal(0, 8, picture.shape), 0, 255) for picture in (first, second)]
        field = estimate_flow(*noisy, method="robust-affine")
        z.append((np.abs(field.displacement - truth) / field.uncertainty)[10:-10, 10:-10])
    assert 0.63 < np.mean(np.less(z, 1)) < 0.80 and 0.92 < np.mean(np.less(z, 1.96)) < 0.98


def test_hidden_pixels_are_not_valid_and_seen_ones_are():
    waves, (x, y), hidden = Waves(3), grid(), 10
    middle = SHAPE[0] // 2  # the upper half slides under the lower one
    first, second = waves(x, y), np.where(y < middle, waves(x, y - hidden), waves(x, y))
    plain, checked = (
        estimate_flow(first, second, method="robust-affine", forward_backward=check).valid[:, 10:-10]
        for check in (False, None)
    )
    assert plain[middle - hidden : middle].all()
    assert checked[middle - hidden : middle].mean() < 0.5
    assert checked[8 : middle - hidden - 6].mean() > 0.99 and checked[middle + 6 : -8].mean() > 0.99


@pytest.mark.parametrize("grey", [0, 128, 255])
def test_constant_pictures_are_not_measured(grey):
    flat = np.full(SHAPE, grey, np.uint8)
    assert not estimate_flow(flat, flat, method="robust-affine").valid.any()


def test_nothing_to_use_is_nothing_measured():
    first, second, _ = affine_pair((1.0, 0.0), np.zeros((2, 2)))
    field = estimate_flow(first, second, method="robust-affine", mask=np.zeros(SHAPE, bool))
    assert not field.valid.any() and np.isnan(field.displacement).all()


def test_small_pictures():
    first, second, truth = affine_pair((0.6, -0.3), np.zeros((2, 2)), shape=(16, 40))
    field = estimate_flow(first, second, method="robust-affine")
    assert np.median(errors(field, truth)[field.valid]) < 0.1
    with pytest.raises(FlowError, match="needs at least 16 px"):
        estimate_flow(first[:, :1], second[:, :1], method="robust-affine")


@pytest.mark.parametrize(
    ("option", "says"),
    [
        ({"preset": "slow"}, "preset: 'slow': allowed are accurate, fast"),
        ({"confidence": 0}, "confidence: 0: must be a number above 0"),
        ({"edges": 1}, "edges: 1: must be true or false"),
        ({"window": 3}, "unknown option window: allowed are preset, confidence, edges"),
        ({"device": "tpu"}, "runs on cpu, cuda"),
    ],
)
def test_bad_options_are_named(option, says):
    picture = np.zeros(SHAPE, np.uint8)
    with pytest.raises(FlowError, match=says):
        estimate_flow(picture, picture, method="robust-affine", **option)


_DIGEST = """
import hashlib, sys
import numpy as np
from soft.flow import estimate_flow
random = np.random.default_rng(0)
first = random.uniform(0, 255, (90, 120)).astype(np.float32)
second = np.roll(first, (1, 2), (0, 1))
field = estimate_flow(first, second, method="robust-affine", threads=int(sys.argv[1]))
print(hashlib.sha256(field.displacement.tobytes() + field.uncertainty.tobytes()).hexdigest())
"""


def test_same_bytes_on_one_and_two_threads(printed_on):
    assert len(printed_on(_DIGEST, (1, 2))) == 1


def test_motion_that_bends_within_the_smallest_windows_is_followed_further(monkeypatch):
    waves, (x, y) = Waves(9, count=400), grid()
    u = 1.5 * np.sin(2 * np.pi * y / 26)  # along x alone: what is at (x, y) comes from (x - u, y)
    first, second, truth = waves(x, y), waves(x - u, y), np.stack([u, 0 * u], -1)
    inner = np.s_[12:-12, 12:-12]

    def off():
        field = estimate_flow(first, second, method="robust-affine", forward_backward=False)
        return np.quantile(errors(field, truth)[inner], 0.9)

    further = off()
    monkeypatch.setattr(windows, "_FURTHER", 0.0)
    assert further < 0.9 * off()
