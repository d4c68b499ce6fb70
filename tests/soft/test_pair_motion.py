import numpy as np
import pytest

from soft import motion_of_pair

SHAPE = (2, 6, 8)


def test_only_measured_soil_has_motion(soil_flow):
    u = np.stack([np.full(SHAPE[1:], 1.0), np.full(SHAPE[1:], 3.0)])
    valid, soil, moving = (np.ones(SHAPE, bool) for _ in range(3))
    valid[1, 2, 2] = soil[1, 3, 3] = moving[1, 4, 4] = False
    motion = motion_of_pair(soil_flow(u, 4 / 3 * u, valid=valid, soil=soil, moving=moving), 1)
    assert np.argwhere(~motion.measured).tolist() == [[2, 2], [3, 3]]
    assert np.isnan(motion.displacement[2, 2]).all()
    assert np.allclose(motion.speed[motion.measured], 5.0)
    assert motion.soil.sum() == 47 and not motion.moving[4, 4]


def test_no_such_pair(soil_flow):
    flow = soil_flow(np.zeros(SHAPE), np.zeros(SHAPE))
    assert motion_of_pair(flow, -1).soil.all()
    with pytest.raises(IndexError):
        motion_of_pair(flow, 2)
