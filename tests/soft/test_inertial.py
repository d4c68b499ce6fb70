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
