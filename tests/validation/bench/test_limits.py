"""Rows of bounds and floors, and why pixels are wrong."""

import numpy as np
import pytest
import xarray as xr

from soft.devices import start_taichi
from synth import load_scene, picture_pair
from validation.bench.flow_case import Case
from validation.bench.limits import bound_rows, evenly, missed_rows, oracle_of, oracle_rows
from validation.bench.rows import BenchRow
from validation.bench.wrong_pixels import causes_in, hidden


@pytest.fixture(scope="module")
def case():
    start_taichi("cpu", 1)
    pair = picture_pair("sand_rotation", quick=True, seed=3)
    first, second = pair.first.astype(np.float32), pair.second.astype(np.float32)
    part = np.zeros(first.shape, bool)
    part[100:120, 180:200] = True
    return Case("sand", first, second, pair.displacement, {"all": pair.valid, "part": part})


def told(rows):
    return {(row.subject, row.metric): row.value for row in rows}


def test_ratios_to_the_bound():
    scene = load_scene("sand_rotation", quick=True)
    row = BenchRow("sand_rotation", "some", "1", False, "all: median error", 0.05, "px", 1)
    other = BenchRow("shear_band", "some", "1", False, "all: median error", 0.05, "px", 1)
    found = told(bound_rows(scene, [row, other]))
    least = found["Cramér-Rao bound, 31 px", "all: median error"]
    assert 0 < found["Cramér-Rao bound, 101 px", "all: median error"] < least < 0.01
    assert found["some", "all: median error / bound, 31 px"] == pytest.approx(0.05 / least)
    assert len(found) == 6


def test_floor_of_a_region(case):
    upper = np.broadcast_to(np.arange(case.first.shape[0])[:, None] < 110, case.first.shape)
    oracle, regions = oracle_of(case), {"part": case.regions["part"]}
    found = told(oracle_rows(case, oracle, regions))
    for subject in ("oracle", "oracle, weighing by its own residuals"):
        assert found[subject, "part: wrong by more than 0.3 px"] == 0
        assert 0 < found[subject, "part: median error"] < found[subject, "part: 95 % error"] < 0.02
    wrong = case.truth.copy()
    wrong[:103] += 1.0  # three lines of the part
    wrong[115] = np.nan  # not measured is wrong too
    missed = told(missed_rows(case, "some", wrong, oracle, regions, {"upper": upper}))
    assert missed["some", "part: wrong where the oracle is right, of all wrong"] == 100
    assert missed["some", "part: wrong where the oracle is right, upper"] == 75


def test_places_are_taken_evenly():
    places = np.argwhere(np.ones((10, 10), bool))
    assert np.array_equal(evenly(places, 100), places)
    assert np.array_equal(evenly(places, 30), places[::4])
    assert len(evenly(places[:0], 30)) == 0


def pair_truth(u):
    u = np.asarray(u, float)
    return xr.Dataset({"u": (("y", "x"), u), "v": (("y", "x"), np.zeros_like(u))})


def test_hidden_grains():
    # Two pixels on the left go two px to the right, over one that stays: it is hidden.
    truth = pair_truth([[2, 2, 0, 0, 0, 0]])
    back = pair_truth([[0, 0, -2, -2, 0, 0]])
    assert hidden(truth, back).tolist() == [[False, False, True, True, False, False]]
    lost = pair_truth([[np.nan, 2, 0, 0, 0, 0]])
    assert hidden(lost, back)[0, 0]


def test_causes_of_a_run(finished_run):
    """Of a rigid plate: all is found again, but what its own edge covers."""
    causes = causes_in(finished_run, 1)
    assert {mask.shape for mask in causes.values()} == {(80, 96)}
    assert not causes["within 3 px of the implement"].any()
    assert causes["hidden in the second picture"].mean() < 0.02
