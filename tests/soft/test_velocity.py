import numpy as np
import pytest

from soft import to_polar, to_velocity


def test_units_and_the_flip():
    """6.25 px at 0.2 mm and 8 frames a second is 1 cm/s; down in the picture is negative z."""
    x, z = to_velocity(np.array([6.25, 3.125], np.float32), metres_per_pixel=2e-4, time_step=1 / 8)
    assert x == pytest.approx(0.01)
    assert z == pytest.approx(-0.005)


def test_polar():
    magnitude, direction = to_polar(
        np.array([1.0, 0.0, -3.0, 0.0, np.nan]), np.array([0.0, 2.0, -4.0, 0.0, 1.0])
    )
    assert np.allclose(magnitude[:4], [1, 2, 5, 0])
    assert np.allclose(direction[:3], [0, np.pi / 2, np.arctan2(-4, -3)])
    assert np.isnan(direction[3:]).all()
