import numpy as np
import pytest

from soft import to_inertial


def field(u, v, shape=(40, 50)):
    return np.broadcast_to(np.array([u, v], np.float32), (*shape, 2)).copy()


def test_camera_to_the_right_sees_soil_move_left():
    flow = field(-3.0, 0.5)
    flow[:10] = (2.0, -1.0)
    flow[30:, 40:] = np.nan
    motion = to_inertial(flow, np.ones((40, 50), bool))
    assert (motion.camera_u, motion.camera_v) == (-3.0, 0.0)
    assert np.allclose(motion.displacement[20, 20], (0.0, 0.5))
    assert np.allclose(motion.displacement[5, 5], (5.0, -1.0))
    assert np.isnan(motion.displacement[35, 45]).all()


def test_only_soil_counts_but_all_is_transformed():
    flow = field(-3.0, 0.0)
    soil = np.zeros((40, 50), bool)
    soil[:10] = True
    flow[soil] = (1.0, 0.25)
    motion = to_inertial(flow, soil, vertical=True)
    assert (motion.camera_u, motion.camera_v) == (1.0, 0.25)
    assert np.allclose(motion.displacement[30, 30], (-4.0, -0.25))


def test_without_valid_soil_the_camera_motion_is_unknown():
    flow = field(1.0, 1.0)
    motion = to_inertial(flow, np.zeros((40, 50), bool))
    assert np.isnan(motion.camera_u)
    assert np.isnan(motion.displacement[..., 0]).all()


@pytest.mark.parametrize("vertical", [False, True])
def test_input_is_not_changed(vertical):
    flow = field(1.0, 1.0)
    to_inertial(flow, np.ones((40, 50), bool), vertical=vertical)
    assert (flow == 1).all()


def test_interval_of_each_component_taken_out():
    rng = np.random.default_rng(0)
    flow = field(-3.0, 0.5, (128, 160)) + rng.normal(0, 0.1, (128, 160, 2)).astype(np.float32)
    soil = np.ones((128, 160), bool)
    motion = to_inertial(flow, soil)
    assert motion.camera_u_low < motion.camera_u < motion.camera_u_high
    assert motion.camera_u_high - motion.camera_u_low < 0.01
    assert np.isnan([motion.camera_v_low, motion.camera_v_high]).all()
    for camera in ("median", "mode", "far"):
        both = to_inertial(flow, soil, vertical=True, camera=camera)
        assert both.camera_v_low < 0.5 < both.camera_v_high
        assert both.camera_u == pytest.approx(-3.0, abs=0.02)


def test_mode_finds_the_camera_where_most_soil_moves():
    flow = field(-3.0, 0.0, (128, 160))
    speed = np.linspace(1, 4, 90)[:, None]
    flow[:90, :, 0] += speed
    soil = np.ones((128, 160), bool)
    assert to_inertial(flow, soil).camera_u > -2
    motion = to_inertial(flow, soil, camera="mode")
    assert motion.camera_u == pytest.approx(-3, abs=1e-3)
    assert np.allclose(motion.displacement[100:, :, 0], 0, atol=1e-3)


def test_other_words_are_refused():
    with pytest.raises(ValueError, match="camera: 'mean': allowed are median, mode, far"):
        to_inertial(field(0, 0), np.ones((40, 50), bool), camera="mean")
