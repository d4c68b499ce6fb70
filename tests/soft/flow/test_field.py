import numpy as np
import pytest

from soft.flow import FlowError, FlowField


def test_not_valid_is_nan_both_ways_and_everywhere():
    displacement = np.zeros((3, 4, 2))
    displacement[0, 0, 1] = np.nan
    displacement[2, 3, 0] = np.inf
    valid = np.ones((3, 4), bool)
    valid[1, 1] = False
    field = FlowField(displacement, valid, np.ones((3, 4, 2)), np.ones((3, 4, 2, 2)))
    dead = [(0, 0), (2, 3), (1, 1)]
    assert field.valid.sum() == 12 - len(dead)
    for where in dead:
        assert np.isnan(field.displacement[where]).all()
        assert np.isnan(field.uncertainty[where]).all()
        assert np.isnan(field.gradient[where]).all()
    assert np.isfinite(displacement[1, 1]).all(), "the caller's array was changed"
    assert field.displacement.dtype == field.uncertainty.dtype == field.gradient.dtype == np.float32


def test_where_takes_away_only():
    field = FlowField(np.zeros((2, 2, 2)), np.array([[True, False], [True, True]]))
    assert field.where(np.array([[True, True], [False, True]])).valid.tolist() == [
        [True, False],
        [False, True],
    ]


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ((np.zeros((3, 4)), np.ones((3, 4), bool)), "displacement"),
        ((np.zeros((3, 4, 2)), np.ones((4, 3), bool)), "valid"),
        ((np.zeros((3, 4, 2)), np.ones((3, 4), bool), np.zeros((3, 4))), "uncertainty"),
        ((np.zeros((3, 4, 2)), np.ones((3, 4), bool), None, np.zeros((3, 4, 4))), "gradient"),
    ],
)
def test_shapes_must_belong_together(arguments, name):
    with pytest.raises(FlowError, match=f"^{name}: shape"):
        FlowField(*arguments)
