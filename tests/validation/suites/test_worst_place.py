"""The worst place is where the error was put, and what is said of it is so."""

import numpy as np
import pytest
import xarray as xr

from validation.scoring.truth_pass import TruePair
from validation.suites.worst_place import SIDE, worst_place

SHAPE = (200, 240)


@pytest.fixture
def truth(make_truth):
    far = np.full(SHAPE, np.inf, np.float32)
    near = far.copy()
    near[50:70, 80:100] = 2.0
    return make_truth(
        np.full(SHAPE, 2.0),
        0.0,
        distance_to_implement=near,
        distance_to_discontinuity=far,
        discontinuity_jump=np.full(SHAPE, np.nan, np.float32),
        strain_rate=np.full(SHAPE, 0.3, np.float32),
        rotation=np.zeros(SHAPE, np.float32),
        camera_u=0.0,
    )


def flow(u):
    return xr.Dataset(
        {"u": (("y", "x"), u.astype(np.float32)), "v": (("y", "x"), np.zeros(SHAPE, np.float32))}
    )


def test_finds_it(truth):
    u = np.full(SHAPE, 2.0)
    u[50:70, 80:100] += 1.0
    place = worst_place(np.full(SHAPE, 100, np.uint8), TruePair(truth), flow(u))
    x, y = place.attrs["worst_at"]
    assert abs(x - 89.5) <= 3 and abs(y - 59.5) <= 3
    assert place.attrs["worst_mean"] == pytest.approx(1.0, abs=1e-3)
    assert place.attrs["worst_because"] == "at the implement, sheared by 0.30 a frame"
    assert place["worst_error"].shape == (SIDE, SIDE)
    assert float(place["worst_error"][SIDE // 2, SIDE // 2]) == pytest.approx(1.0)


def test_what_is_not_measured_is_bad(truth):
    u = np.full(SHAPE, 2.1)
    u[100:130, 10:40] = np.nan
    place = worst_place(np.zeros(SHAPE), TruePair(truth), flow(u))
    assert "100% not measured" in place.attrs["worst_because"]
    x, y = place.attrs["worst_at"]
    assert 10 <= x < 40 and 100 <= y < 130


def test_at_the_picture_s_corner(truth):
    u = np.full(SHAPE, 2.0)
    u[:12, :12] += 5
    place = worst_place(np.full(SHAPE, 7, np.uint8), TruePair(truth), flow(u))
    assert place["worst_picture"][0, 0] == 0 and np.isnan(place["worst_error"][0, 0])
