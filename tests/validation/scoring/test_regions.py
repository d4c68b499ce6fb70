import json

import numpy as np
import pytest
import xarray as xr

from validation.scoring.method_scores import score_methods
from validation.scoring.regions import RegionScore, RegionTally
from validation.scoring.score import Scores
from validation.scoring.score_table import REGION_COLUMNS, region_cells
from validation.scoring.truth_pass import TruePair

SHAPE = (100, 140)
Y, X = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
SOIL = Y >= 20


def moving_by(depth):
    """Inertial u (H, W): soil above row `depth` goes to the right by up to 4 px, below it rests."""
    return np.clip(2.0 * (depth + 1 - Y), 0, 4.0)


def truth_of(make_truth, u, **others):
    crest = np.exp(-np.square((Y - 60.5) / 6)).astype(np.float32)
    return make_truth(u - 5.0, 0.0, soil=SOIL, camera_u=-5.0, strain_rate=crest, **others)


@pytest.fixture
def measured():
    """A SoilFlow as far as regions need it, of inertial u (P, H, W)."""

    def make(u, *, soil=SOIL, moving=None, camera_u=-5.0):
        from soft import moving_mask

        u = np.asarray(u, np.float32)
        soil = np.broadcast_to(soil, u.shape)
        if moving is None:
            moving = np.stack(
                [moving_mask(np.abs(one), ground).mask for one, ground in zip(u, soil, strict=True)]
            )
        dims, pairs = ("pair", "y", "x"), np.arange(len(u))
        arrays = {"u": u + camera_u, "v": 0 * u, "inertial_u": u, "inertial_v": 0 * u, "soil": soil,
                  "moving": moving, "valid": np.ones(u.shape, bool)}  # fmt: skip
        return xr.Dataset(
            {name: (dims, array) for name, array in arrays.items()},
            {"first_frame": ("pair", pairs), "second_frame": ("pair", pairs + 1)},
            {"seed": 0},
        )

    return make


@pytest.fixture
def footage(make_truth, make_footage):
    truth = truth_of(make_truth, moving_by(60.5))
    return make_footage(truth, truth)


def counts_of(score):
    return score.interface_pair_count, score.interface_missed_count, score.interface_false_count


def test_the_truth_itself_is_right(footage, measured, tallied):
    score = tallied(RegionTally(), footage, measured([moving_by(60.5)] * 2))
    assert (score.soil_iou, score.moving_iou) == (1.0, 1.0)
    assert (score.interface_pair_count, score.interface_missed_count, score.interface_false_count) == (
        2,
        0,
        0,
    )
    assert score.interface_p95 == pytest.approx(0, abs=1e-6)
    assert score.interface_symmetric_p95 == pytest.approx(0, abs=1e-6)


def test_an_interface_that_lies_too_deep(footage, measured, tallied):
    """Measured 7 px deeper than it is: the distance, and the moving region's share."""
    score = tallied(RegionTally(), footage, measured([moving_by(67.5)] * 2))
    # Not quite 7: with more soil moving, the classes' middle is not at quite the same speed.
    assert score.interface_mean == pytest.approx(7, abs=0.1)
    assert score.interface_symmetric_p95 == pytest.approx(7, abs=0.1)
    assert score.moving_iou == pytest.approx(41 / 48)


def test_the_line_of_greatest_shear_is_told_apart(footage, measured, tallied):
    """Speed is half of its greatest at row 60.5: the true line is there, shear greatest as well."""
    score = tallied(RegionTally(), footage, measured([moving_by(67.5)] * 2))
    assert score.shear_line_true_mean == pytest.approx(0, abs=0.6)
    assert score.shear_line_mean == pytest.approx(7, abs=0.6)


def test_an_interface_in_one_of_them_only(make_truth, make_footage, measured, tallied):
    moves, rests = truth_of(make_truth, moving_by(60.5)), truth_of(make_truth, 0 * Y)
    both = make_footage(moves, rests)
    score = tallied(RegionTally(), both, measured([0 * Y, moving_by(60.5)]))
    assert (score.interface_pair_count, score.interface_missed_count, score.interface_false_count) == (
        0,
        1,
        1,
    )
    assert score.interface_mean is None and score.moving_iou == 0.0


def test_soil_that_was_taken_for_the_implement(footage, measured, tallied):
    score = tallied(RegionTally(), footage, measured([moving_by(60.5)] * 2, soil=Y >= 30))
    assert score.soil_iou == pytest.approx(70 / 80)


def test_the_cameras_error_moves_the_line(footage, measured, tallied):
    """With 0.5 px of camera motion left in, all speeds are 0.5 px higher; so is the threshold."""
    score = tallied(RegionTally(), footage, measured([moving_by(60.5) + 0.5] * 2))
    assert score.interface_mean == pytest.approx(0, abs=0.05)
    # The other way, speeds of 3.5 and 0.5 px part at 2 px: where the true speed is 2.5 px, 0.25 px higher up.
    score = tallied(RegionTally(), footage, measured([np.abs(moving_by(60.5) - 0.5)] * 2))
    assert score.interface_mean == pytest.approx(0.25, abs=0.1)


def test_what_the_camera_does_to_the_line_is_told_apart(footage, measured, tallied):
    flow = measured([np.abs(moving_by(60.5) - 0.5)] * 2).assign(u=measured([moving_by(60.5)] * 2)["u"])
    score = tallied(RegionTally(), footage, flow)
    assert score.interface_mean > 0.1
    assert score.interface_true_camera_mean == pytest.approx(0, abs=1e-6)


def test_without_masks_there_is_nothing_to_score(make_flow):
    assert not RegionTally.suits(make_flow(np.zeros((2, *SHAPE)), np.zeros((2, *SHAPE))))


def test_of_a_grid_the_line_is_scored_between_its_nodes(footage, measured, tallied):
    flow = measured([moving_by(60.5)] * 2)
    held = (X % 8 == 4) & (Y % 8 == 4)
    nodes = {
        f"node_{name}": (("pair", "y", "x"), np.stack(2 * [np.where(held, place, np.nan)]))
        for name, place in (("x", X), ("y", Y))
    }
    at_nodes = {name: flow[name].where(held) for name in ("u", "v", "inertial_u", "inertial_v")}
    flow = flow.assign(nodes | at_nodes | {"valid": flow["valid"] & held})
    score = tallied(RegionTally(), footage, flow)
    assert score.soil_iou == 1.0 and score.interface_pair_count == 2
    assert score.interface_p95 < 3  # nodes are 8 px apart


def test_true_regions_use_the_true_camera(make_truth):
    found = TruePair(truth_of(make_truth, moving_by(60.5))).regions
    assert found.interface[:, 1] == pytest.approx(np.full(len(found.interface), 60.5), abs=0.1)


def test_in_words(footage, measured, tallied):
    found = tallied(RegionTally(), footage, measured([moving_by(67.5), 0 * Y]))
    cells = region_cells(found)
    assert len(cells) == len(REGION_COLUMNS)
    assert cells[:3] == ["1.0000", f"{found.moving_iou:.3f}", "1 of 2"]
    assert cells[3] == "7.0 / 7.0"


def test_written_and_read(footage, measured, tmp_path):
    flows = {"own": measured([moving_by(61.5)] * 2)}
    scores = Scores("", 0, False, score_methods(footage, flows, seconds={"own": 0.5}), {})
    region = scores.methods["own"].regions
    scores.write(tmp_path / "scores.json")
    assert Scores.read(tmp_path / "scores.json") == scores
    table = json.loads((tmp_path / "scores.json").read_text())["methods"]["own"]
    assert table["interface_p95"] == region.interface_p95
    assert set(RegionScore.__dataclass_fields__) <= set(table)
