"""What chance does to a curve."""

import csv

import numpy as np
import pytest

from synth.rover.drawbar import DrawbarPoint
from validation.drawbar.chance import chances, write_chance
from validation.drawbar.curve import Curve, orders_of, repeated

REDUCTIONS = (0.0, 0.1, 0.3, 0.5)
(ORDER,) = orders_of("scarab", gaits=["inching"], wheels=["rigid"])


def curve(order, scale):
    points = tuple(DrawbarPoint(scale * one, 0.05, one, ()) for one in REDUCTIONS)
    return Curve(order, 2700.0, points)


def test_repeats_are_the_same_but_for_a_little_speed():
    again = repeated([ORDER], 3)
    assert [one.name for one in again] == ["inching-rigid-rft-repeat-1", "inching-rigid-rft-repeat-2"]
    assert [one.rim_speed for one in (ORDER, *again)] == pytest.approx([0.06, 0.06024, 0.06048])
    assert {one.speed for one in again} == {ORDER.speed}


def test_mean_and_deviation_are_of_the_repeats_that_got_there(tmp_path):
    curves = [
        curve(one, scale) for one, scale in zip((ORDER, *repeated([ORDER], 3)), (0.9, 1.0, 1.1), strict=True)
    ]
    found = chances(curves)
    assert [one.reduction for one in found] == [0.1, 0.2, 0.4]  # none got to the maximum's
    for one in found:
        assert one.order == ORDER
        assert one.mean == pytest.approx(one.reduction)
        assert one.deviation == pytest.approx(0.1 * one.reduction)
    path = write_chance(curves, tmp_path / "chance.csv")
    rows = list(csv.DictReader(path.read_text().splitlines()))
    assert [row["repeats"] for row in rows] == ["3"] * 3
    np.testing.assert_allclose([float(row["greatest"]) for row in rows], [0.11, 0.22, 0.44], atol=1e-4)


def test_one_curve_has_no_deviation():
    assert np.isnan(chances([curve(ORDER, 1.0)])[0].deviation)
