import numpy as np
import pytest

from soft import direction_of, significant_direction


def test_known_directions_inside_and_nothing_outside():
    displacement = np.array(
        [[[1.0, 0.0], [0.0, -2.0], [-1.0, 1.0], [0.0, 0.0], [np.nan, np.nan], [3.0, 3.0]]]
    )
    moving = np.array([[True, True, True, True, True, False]])
    direction = significant_direction(displacement, moving)
    assert direction.dtype == np.float32
    # y points down in the picture: (0, -2) is up, (-1, 1) is left and down.
    assert direction[0, :3] == pytest.approx([0.0, np.pi / 2, -3 * np.pi / 4])
    assert np.isnan(direction[0, 3:]).all()


def test_shapes():
    with pytest.raises(ValueError, match="moving: shape"):
        significant_direction(np.zeros((3, 4, 2)), np.zeros((4, 3), bool))


def test_of_a_soil_flow(soil_flow):
    u = np.full((2, 6, 8), 1.0)
    moving, valid = np.zeros(u.shape, bool), np.ones(u.shape, bool)
    moving[1, 2:4, 2:4] = True
    valid[1, 2, 2] = False
    flow = soil_flow(u, u, moving=moving, valid=valid)
    assert np.isnan(direction_of(flow, pair=0)).all()
    assert np.isfinite(direction_of(flow, pair=1)).sum() == 3
    assert direction_of(flow, pair=1)[3, 3] == pytest.approx(-np.pi / 4)
