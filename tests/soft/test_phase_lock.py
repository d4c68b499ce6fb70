import numpy as np
import pytest

from soft import average_flow, grouser_phase, phase_locked_average, wheel_angle_of

SHAPE = (30, 40)
Y, X = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
AMPLITUDE = 3.0 * np.exp(-(np.square(X - 20) + np.square(Y - 15)) / 60)


def periodic(phase):
    """Soil that swings with the passing of grousers: (2, H, W) px."""
    return np.stack([AMPLITUDE * np.cos(2 * np.pi * phase), AMPLITUDE * np.sin(2 * np.pi * phase)])


def test_a_periodic_event_is_not_blurred(soil_flow):
    phase = ((89 * np.arange(240)) % 240 + 0.5) / 240
    fields = np.stack([periodic(p) for p in phase])
    flow = soil_flow(*np.moveaxis(fields, 1, 0))
    assert np.abs(average_flow(flow).u).max() < 0.01  # a plain mean has lost it
    locked = phase_locked_average(flow, phase, bin_count=8)
    assert locked.pair_count.sum() == 240 and locked.pair_count.min() == 30
    assert np.array_equal(locked.phase, np.arange(8) / 8)
    for middle, mean in zip(locked.phase, locked.means, strict=True):
        expected = np.sinc(1 / 8) * periodic(middle)
        assert np.allclose(mean.u, expected[0], atol=0.01)
        assert np.allclose(mean.v, expected[1], atol=0.01)


def test_bins_are_centred_and_wrap_around(soil_flow):
    phase = np.array([0.06, 0.94, 1.0, 0.07, 0.26, -0.74])
    u = np.stack([np.full(SHAPE, value) for value in (1.0, 2.0, 3.0, 9.0, 5.0, 7.0)])
    locked = phase_locked_average(soil_flow(u, u), phase, bin_count=8)
    assert locked.pair_count.tolist() == [3, 1, 2, 0, 0, 0, 0, 0]
    assert np.all(locked.means[0].u == 2.0) and np.all(locked.means[2].u == 6.0)
    assert locked.means[3] is None
    assert "5 of them empty" in locked.remark


def test_bins_share_one_place_for_the_implement(soil_flow):
    places = np.array([[10.0, 5.0], [12.0, 5.0], [14.0, 5.0], [16.0, 5.0]])
    u = np.stack([np.where(x + 3 == X, 4.0, 0.0) for x in places[:, 0]])
    locked = phase_locked_average(
        soil_flow(u, 0 * u), np.array([0, 0.5, 0, 0.5]), bin_count=2, positions=places
    )
    for mean in locked.means:
        assert np.argmax(np.nan_to_num(mean.u[5])) == 13 and mean.u[5, 13] == 4.0


def test_phase_from_the_wheels_angle():
    angle = np.array([0.0, np.pi / 12, np.pi / 6, np.pi / 3 + np.pi / 12])
    assert grouser_phase(angle, grouser_count=12) == pytest.approx([0.0, 0.5, 0.0, 0.5], abs=1e-12)
    assert grouser_phase(-np.pi / 24, grouser_count=12) == pytest.approx(0.75)
    with pytest.raises(ValueError, match="grouser_count: 0"):
        grouser_phase(angle, grouser_count=0)


def test_angle_from_time_is_that_of_the_pairs_middle(soil_flow):
    flow = soil_flow(np.zeros((3, *SHAPE)), np.zeros((3, *SHAPE)))  # 8 frames a second
    assert wheel_angle_of(flow, angular_speed=0.8, start=0.1) == pytest.approx([0.15, 0.25, 0.35])
    del flow.attrs["frame_rate"]
    with pytest.raises(ValueError, match="frame_rate: unknown"):
        wheel_angle_of(flow, angular_speed=0.8)


def test_refused(soil_flow):
    flow = soil_flow(np.zeros((3, *SHAPE)), np.zeros((3, *SHAPE)))
    with pytest.raises(ValueError, match="phase: shape"):
        phase_locked_average(flow, np.zeros(2))
    with pytest.raises(ValueError, match="bin_count: 0"):
        phase_locked_average(flow, np.zeros(3), bin_count=0)
