import numpy as np
import pytest

from validation.scoring.line_distance import distances, points_along


def test_points_stand_for_equal_lengths():
    short, long = np.array([[0.0, 0.0], [0.0, 10.0]]), np.array([[5.0, 0.0], [35.0, 40.0], [35.0, 90.0]])
    points = points_along([short, long])
    on_short = points[:, 0] == 0
    assert on_short.sum() == pytest.approx(10 / 0.25, abs=1)
    assert (~on_short).sum() == pytest.approx(100 / 0.25, abs=1)
    assert points_along([]).shape == (0, 2)


def test_parallel_lines_and_their_ends():
    one = points_along([np.array([[0.0, 0.0], [100.0, 0.0]])])
    other = points_along([np.array([[20.0, 3.0], [120.0, 3.0]])])
    off = distances(one, other)
    assert off[one[:, 0] >= 20] == pytest.approx(np.full((one[:, 0] >= 20).sum(), 3.0), abs=0.01)
    assert off[0] == pytest.approx(np.hypot(20, 3))


def test_circles():
    angle = np.linspace(0, 2 * np.pi, 400)
    circles = [points_along([r * np.stack([np.cos(angle), np.sin(angle)], axis=1)]) for r in (30.0, 34.0)]
    assert np.abs(distances(*circles) - 4).max() < 0.02


def test_nothing_to_compare_with():
    assert np.isinf(distances(np.zeros((2, 2)), np.empty((0, 2)))).all()
    assert distances(np.empty((0, 2)), np.zeros((2, 2))).shape == (0,)
