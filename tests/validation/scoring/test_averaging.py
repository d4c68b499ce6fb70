import json

import numpy as np
import pytest
import xarray as xr

from synth.text_files import checked
from validation.scoring.averaging import AveragingScore, AveragingTally

SHAPE = (40, 50)
PAIRS = 16


@pytest.fixture
def footage(make_truth, make_footage):
    soil = np.ones(SHAPE, bool)
    soil[:5] = False
    return make_footage(
        *(make_truth(np.full(SHAPE, k - 5.0), 0.5, soil=soil, camera_u=-5.0) for k in range(PAIRS))
    )


def measured(error):
    """Inertial motion k px to the right in pair k, 0.5 px down, and an error (P, 2, H, W)."""
    true = np.stack([np.stack([np.full(SHAPE, float(k)), np.full(SHAPE, 0.5)]) for k in range(PAIRS)])
    dims = ("pair", "y", "x")
    found = (true + error).astype(np.float32)
    everywhere = np.ones((PAIRS, *SHAPE), bool)
    arrays = {"inertial_u": found[:, 0], "inertial_v": found[:, 1], "valid": everywhere, "soil": everywhere}
    return xr.Dataset({name: (dims, array) for name, array in arrays.items()})


def test_independent_errors_fall_with_the_square_root(footage, tallied):
    noise = np.random.default_rng(0).normal(0, 0.2, (PAIRS, 2, *SHAPE))
    score = tallied(AveragingTally(), footage, measured(noise))
    assert score.pair_count == (1, 2, 4, 8, 16)
    assert score.error[0] == pytest.approx(0.2 * np.sqrt(2), rel=0.02)
    assert score.gain == pytest.approx(np.sqrt(score.pair_count), rel=0.05)


def test_an_error_that_repeats_stays(footage, tallied):
    """Which the data alone cannot tell from signal."""
    noise = np.random.default_rng(1).normal(0, 0.2, (PAIRS, 2, *SHAPE))
    score = tallied(AveragingTally(), footage, measured(noise + np.array([0.3, -0.4])[:, None, None]))
    for count, error in zip(score.pair_count, score.error, strict=True):
        assert error == pytest.approx(np.sqrt(0.25 + 0.08 / count), rel=0.02)
    assert "takes the error (root mean square) from 0.57" in score.sentence


def test_unmeasured_pixels_and_those_that_are_no_soil(footage, tallied):
    flow = measured(np.zeros((PAIRS, 2, *SHAPE)))
    flow["inertial_u"][:, :5] = 99.0  # no soil there in truth
    flow["valid"][3, 10] = False
    flow["inertial_u"][3, 10] = 99.0
    score = tallied(AveragingTally(), footage, flow)
    assert score.error == pytest.approx(np.zeros(5), abs=1e-6)


def test_neither_without_inertial_motion_nor_for_a_grid(make_flow):
    assert not AveragingTally.suits(make_flow(np.zeros((PAIRS, *SHAPE)), np.zeros((PAIRS, *SHAPE))))
    flow = measured(np.zeros((PAIRS, 2, *SHAPE)))
    assert AveragingTally.suits(flow)
    assert not AveragingTally.suits(flow.assign(node_x=flow["inertial_u"]))


def test_there_and_back():
    score = AveragingScore((1, 2), (0.5, 0.4))
    told = json.loads(json.dumps(score.to_dict()))
    assert checked(AveragingScore, told["averaging"]) == score
    assert AveragingScore((1,), (0.5,)).sentence == ""
