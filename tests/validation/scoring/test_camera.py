import numpy as np
import pytest
import xarray as xr

from validation.scoring.camera import CameraScore, CameraTally
from validation.scoring.truth_pass import TruePair


def pairs(**values):
    return xr.Dataset({name: ("pair", np.array(v, float)) for name, v in values.items()})


@pytest.fixture
def score_camera(make_truth):
    """Score flow against soil of 40 x 40 px that moves by `soil_u` px in each pair."""

    def score_camera(flow, *, soil_u, camera_u=None):
        tally = CameraTally.of(flow)
        for k, u in enumerate(soil_u):
            told = {} if camera_u is None else {"camera_u": camera_u[k]}
            tally.add(TruePair(make_truth(np.full((40, 40), u), 0.0, **told)), flow.isel(pair=k))
        return tally.result()

    return score_camera


def test_error_is_measured_less_true(score_camera):
    flow = pairs(
        camera_u=[-6.9, -7.3, -7.1, np.nan],
        camera_u_low=[-7.05, -7.35, np.nan, np.nan],
        camera_u_high=[-6.8, -7.25, np.nan, np.nan],
    )
    score = score_camera(flow, camera_u=[-7.0, -7.4, -7.2, -7.2], soil_u=[-7.0, -7.35, -7.1, -7.2])
    assert score.pair_count == 3
    assert score.bias_u == pytest.approx(0.1)
    assert score.range_u == pytest.approx(0, abs=1e-9)
    assert score.largest_u == pytest.approx(0.1)
    assert score.measured_range_u == pytest.approx(1.96 * 0.2)
    assert score.true_range_u == pytest.approx(1.96 * 0.2)
    assert score.covered == 0.5
    assert score.soil_range_u == pytest.approx(1.96 * 0.05, rel=1e-4)
    assert score.flow_range_u == pytest.approx(1.96 * 0.05, rel=1e-4)
    assert "off by +0.100 ± 0.000 px (95 % of 3 pairs: flow ± 0.098, soil that does not rest" in str(score)
    assert CameraScore(**score.to_dict()) == score


def test_nothing_to_tell(score_camera):
    assert score_camera(pairs(camera_u=[1.0]), soil_u=[1.0]) is None
    score = score_camera(pairs(camera_u=[np.nan]), camera_u=[1.0], soil_u=[1.0])
    assert (score.pair_count, score.bias_u, score.covered) == (0, None, None)
    assert str(score) == "not measured"
    assert "1 pair" in str(score_camera(pairs(camera_u=[1.5]), camera_u=[1.0], soil_u=[1.0]))
