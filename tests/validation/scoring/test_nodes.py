"""A grid is judged where it was measured, and motion that nothing has is not made up."""

import numpy as np
import pytest

from validation.scoring.metrics import ErrorTally
from validation.scoring.nodes import difference_at, truth_at

SHAPE = (30, 40)


def linear(x, y):
    return np.stack([1 + 0.03 * x - 0.02 * y, -2 + 0.05 * x + 0.01 * y], axis=-1)


def test_between_pixels_that_move_alike_the_truth_is_linear():
    y, x = np.indices(SHAPE, dtype=float)
    places = np.array([[10.3, 20.8], [5.0, 7.0], [38.9, 28.6], [39.0, 29.0], [0.0, 0.0]])
    assert truth_at(linear(x, y), places) == pytest.approx(linear(places[:, 0], places[:, 1]), abs=1e-12)


def test_at_a_break_the_nearest_pixel_counts():
    truth = np.zeros((*SHAPE, 2))
    truth[:, 20:] = (4.0, -1.0)
    assert truth_at(truth, np.array([[19.4, 10.0], [19.6, 10.0]])).tolist() == [[0, 0], [4, -1]]


def test_beside_unknown_truth_the_nearest_pixel_counts():
    truth = np.ones((*SHAPE, 2))
    truth[:, 20:] = np.nan
    told = truth_at(truth, np.array([[19.4, 10.0], [19.6, 10.0]]))
    assert told[0].tolist() == [1, 1] and np.isnan(told[1]).all()


def test_difference_is_taken_at_the_node():
    y, x = np.indices(SHAPE, dtype=float)
    truth, nodes = linear(x, y), np.full((*SHAPE, 2), np.nan)
    displacement = np.full((*SHAPE, 2), np.nan)
    nodes[12, 7] = (7.4, 11.6)
    displacement[12, 7] = linear(7.4, 11.6) + np.array([0.25, 0])
    difference = difference_at(displacement, truth, nodes)
    assert difference[12, 7] == pytest.approx([0.25, 0], abs=1e-6)
    assert np.isfinite(difference).sum() == 2
    assert difference_at(truth + 1, truth, None) == pytest.approx(np.ones((*SHAPE, 2)))


def test_shares_are_of_nodes_and_coverage_is_of_pixels():
    tally = ErrorTally()
    error = np.full(1000, np.nan)
    error[:3] = 0.1, 0.5, 2.0
    tally.add(error, np.zeros(1000), node_count=4)
    tally.add(np.full(1000, np.nan), np.full(1000, np.nan), node_count=0)
    summary = ErrorTally.summary([tally])
    assert (summary.pixel_count, summary.node_count, summary.coverage) == (2000, 4, 3 / 2000)
    assert summary.wrong_share == {"0.3": 0.75, "0.56": 0.5, "1.0": 0.5}
    assert summary.median == pytest.approx(0.5)
    assert "node_count" not in ErrorTally.summary([ErrorTally()]).to_dict()
    assert summary.to_dict()["node_count"] == 4


def test_a_node_fills_its_cell_within_soil():
    from validation.pair_view import Measured, Motion

    error = np.full(SHAPE, np.nan)
    error[10, 4:28:8], error[10, 12] = 0.7, 0.9
    none, soil = np.zeros(SHAPE), np.ones(SHAPE, bool)
    soil[:8] = False
    grid, dense = (
        Measured(Motion(none, none), error, none > 0, 0.0, soil, gridded=gridded) for gridded in (True, False)
    )
    shown = grid.shown(error)
    assert np.argwhere(np.isfinite(shown))[[0, -1]].tolist() == [[8, 0], [14, 24]]
    assert (shown[8:15, 9:16] == 0.9).all() and (shown[8:15, 17:24] == 0.7).all()
    assert dense.shown(error) is error
