import numpy as np
import pytest

from soft import average_flow

SHAPE = (40, 60)
Y, X = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
SIGNAL = np.stack([2.0 * np.exp(-np.square(X - 30) / 200), -0.5 * Y / SHAPE[0]])


def ar1(count, correlation, rng):
    """Noise of one sigma whose values `k` pairs apart correlate by `correlation ** k`."""
    noise = rng.normal(size=(count, 2, *SHAPE))
    for k in range(1, count):
        noise[k] = correlation * noise[k - 1] + np.sqrt(1 - correlation**2) * noise[k]
    return noise


def test_mean_of_vectors_and_not_of_magnitudes(soil_flow):
    u = np.stack([np.full(SHAPE, 3.0), np.full(SHAPE, -3.0), np.full(SHAPE, 3.0)])
    mean = average_flow(soil_flow(u, np.zeros_like(u)))
    assert np.allclose(mean.u, 1.0) and np.allclose(mean.speed, 1.0)
    assert np.allclose(mean.standard_error_u, np.std([3, -3, 3], ddof=1) / np.sqrt(3))
    assert np.all(mean.standard_error_v == 0) and np.all(mean.count == 3)
    assert mean.pairs == (0, 1, 2)


def test_only_pairs_in_which_it_was_measured_on_soil(soil_flow):
    u = np.stack([np.full(SHAPE, float(k)) for k in range(4)])
    valid, soil = np.ones(u.shape, bool), np.ones(u.shape, bool)
    valid[0, 5, 5] = valid[1:, 6, 6] = False
    valid[:, 7, 7] = False
    soil[2:, 8, 8] = False
    soil[1:, 9, 9] = False
    mean = average_flow(soil_flow(u, np.zeros_like(u), valid=valid, soil=soil))
    assert (mean.u[5, 5], mean.count[5, 5]) == (2.0, 3)
    assert (mean.u[6, 6], mean.count[6, 6]) == (0.0, 1) and np.isnan(mean.standard_error_u[6, 6])
    assert np.isnan(mean.u[7, 7]) and mean.count[7, 7] == 0
    assert (mean.u[8, 8], mean.count[8, 8]) == (0.5, 2)
    assert mean.soil[8, 8] and not mean.soil[9, 9]


def test_chosen_pairs(soil_flow):
    u = np.stack([np.full(SHAPE, float(k)) for k in range(4)])
    flow = soil_flow(u, u)
    assert np.all(average_flow(flow, pairs=[1, -1]).u == 2.0)
    assert average_flow(flow, pairs=[1, -1]).pairs == (1, 3)
    with pytest.raises(IndexError):
        average_flow(flow, pairs=[4])
    with pytest.raises(ValueError, match="pairs: none"):
        average_flow(flow, pairs=[])


def test_in_the_frame_of_an_implement_that_crosses_the_picture(soil_flow):
    """The same field, each time 3 px further to the right and 1 px up."""
    positions = np.array([[10.2 + 3 * k, 20.4 - k] for k in range(5)])
    fields = [SIGNAL_AT(X - 3 * k, Y + k) for k in range(5)]
    flow = soil_flow(np.stack([f[0] for f in fields]), np.stack([f[1] for f in fields]))
    mean = average_flow(flow, positions=positions)
    seen = mean.count == 5
    assert np.allclose(mean.u[seen], SIGNAL_AT(X, Y)[0][seen], atol=1e-6)
    assert np.allclose(mean.v[seen], SIGNAL_AT(X, Y)[1][seen], atol=1e-6)
    assert seen[:, : SHAPE[1] - 12].mean() == pytest.approx((SHAPE[0] - 4) / SHAPE[0])
    assert np.all(mean.count[:, -1] == 1)  # out of view in all but the first
    elsewhere = average_flow(flow, positions=positions, reference=(13.2, 20.4))
    assert np.allclose(elsewhere.u[10, 20], mean.u[10, 17])
    with pytest.raises(ValueError, match=r"positions: shape \(3, 2\): must be \(5, 2\)"):
        average_flow(flow, positions=positions[:3])


def SIGNAL_AT(x, y):  # noqa: N802
    return np.stack([2.0 * np.exp(-np.square(x - 20) / 50), 0.1 * y]).astype(np.float32)


def test_independent_errors_gain_the_square_root(soil_flow):
    noise = np.random.default_rng(0).normal(0, 0.3, (64, 2, *SHAPE))
    mean = average_flow(soil_flow(*np.moveaxis(SIGNAL + noise, 1, 0)))
    gain = mean.gain
    assert gain.pair_count.tolist() == [1, 2, 4, 8, 16, 32]
    assert gain.block_count.tolist() == [32, 16, 8, 4, 2, 1]
    assert gain.noise[0] == pytest.approx(0.3 * np.sqrt(2), rel=0.01)
    assert gain.gain == pytest.approx(np.sqrt(gain.pair_count), rel=0.04)
    assert gain.signal == pytest.approx(np.sqrt(np.square(SIGNAL).sum(axis=0).mean()), rel=0.01)
    assert mean.standard_error_u.mean() == pytest.approx(0.3 / 8, rel=0.02)
    assert np.std(mean.u - SIGNAL[0]) == pytest.approx(0.3 / 8, rel=0.05)
    assert "gained 5.6" in gain.remark or "gained 5.7" in gain.remark


def test_correlated_errors_gain_less_as_theory_says(soil_flow):
    """Variance of a mean over N of an autoregression: (1 + 2 sum (1 - k/N) r^k) / N."""
    noise = ar1(128, 0.6, np.random.default_rng(1))
    gain = average_flow(soil_flow(*np.moveaxis(SIGNAL + 0.2 * noise, 1, 0))).gain
    for n, got in zip(gain.pair_count[:5], gain.gain[:5], strict=True):
        k = np.arange(1, n)
        variance = (1 + 2 * ((1 - k / n) * 0.6**k).sum()) / n
        assert got == pytest.approx(1 / np.sqrt(variance), rel=0.05)
    assert gain.lost[4] == pytest.approx(1 - gain.gain[4] / 4)
    assert 0.4 < gain.lost[4] < 0.6


def test_noise_of_a_shared_picture_helps(soil_flow):
    """Noise of a picture displaces one pair's vector forwards and the next one's backwards."""
    picture = np.random.default_rng(2).normal(0, 0.2, (65, 2, *SHAPE))
    gain = average_flow(soil_flow(*np.moveaxis(SIGNAL + np.diff(picture, axis=0), 1, 0))).gain
    assert gain.gain[:4] == pytest.approx(gain.pair_count[:4], rel=0.05)
    assert np.all(gain.lost[1:] < 0)


def test_an_error_common_to_all_pairs_counts_as_signal(soil_flow):
    noise = np.random.default_rng(3).normal(0, 0.1, (16, 2, *SHAPE))
    gain = average_flow(soil_flow(*np.moveaxis(SIGNAL + 1.0 + noise, 1, 0))).gain
    assert gain.signal[0] > np.sqrt(np.square(SIGNAL).sum(axis=0).mean()) + 0.2
    assert gain.gain[-1] == pytest.approx(np.sqrt(8), rel=0.1)


def test_missing_vectors_do_not_change_the_noise(soil_flow):
    rng = np.random.default_rng(4)
    noise = rng.normal(0, 0.3, (32, 2, *SHAPE))
    valid = rng.uniform(size=(32, *SHAPE)) > 0.1
    gain = average_flow(soil_flow(*np.moveaxis(SIGNAL + noise, 1, 0), valid=valid)).gain
    assert gain.gain[:4] == pytest.approx(np.sqrt(gain.pair_count[:4]), rel=0.06)


def test_one_pair(soil_flow):
    mean = average_flow(soil_flow(*np.moveaxis(SIGNAL[None], 1, 0)))
    assert np.allclose(mean.displacement, np.moveaxis(SIGNAL, 0, -1), atol=1e-6)
    assert np.isnan(mean.standard_error_u).all()
    assert len(mean.gain.pair_count) == 0 and "single pair" in mean.gain.remark


def test_two_pairs_tell_noise_but_no_gain(soil_flow):
    noise = np.random.default_rng(5).normal(0, 0.3, (2, 2, *SHAPE))
    gain = average_flow(soil_flow(*np.moveaxis(SIGNAL + noise, 1, 0))).gain
    assert gain.pair_count.tolist() == [1]
    assert gain.noise[0] == pytest.approx(0.3 * np.sqrt(2), rel=0.05)
    assert gain.remark.endswith("more pairs tell the gain")


def test_progress_and_scale(soil_flow):
    seen = []
    flow = soil_flow(*np.moveaxis(np.stack([SIGNAL] * 5), 1, 0))
    mean = average_flow(flow, progress=lambda done, count: seen.append((done, count)))
    assert seen == [(2, 5), (4, 5), (5, 5)]
    assert (mean.metres_per_pixel, mean.frame_rate) == (2e-4, 8.0)


def test_from_a_file_as_from_memory(soil_flow, tmp_path):
    from soft import read_soil_flow

    flow = soil_flow(*np.moveaxis(np.stack([SIGNAL, 2 * SIGNAL, SIGNAL]), 1, 0))
    flow.to_netcdf(tmp_path / "flow.nc", engine="h5netcdf")
    with read_soil_flow(tmp_path / "flow.nc") as stored:
        assert np.array_equal(average_flow(stored).u, average_flow(flow).u)
