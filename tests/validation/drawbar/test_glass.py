"""Soil motion of both halves of push-rolling beside the rover's forces."""

import csv

import numpy as np
import pytest

from synth.rover.balance import PhaseMean, WheelMean
from synth.rover.drawbar import DrawbarPoint
from validation.drawbar.curve import Curve, CurveOrder
from validation.drawbar.glass import (
    GlassError,
    GlassView,
    Seen,
    both,
    glass_figure,
    thrust_over_load,
    write_glass_table,
)


def seen(along):
    directions = np.zeros(36)
    directions[:4] = 0.25
    return Seen(along, 1 - along, 0.8, 40.0, directions)


VIEWS = {
    "rolling": GlassView("rolling", 0.1, {"measured": seen(0.4), "true": seen(0.41)}),
    "pushed": GlassView("pushed", 0.3, {"measured": seen(0.7), "true": seen(0.72)}),
}


def point(pull):
    """Rear wheels stand while it expands; what stands thrusts 0.4 of its load, what rolls 0.1."""

    def wheel(name, share):
        return WheelMean(name, share * 600.0, 600.0, -50.0, 0.5, 0.5, 0.03)

    expand = PhaseMean("expand", 8.0, (wheel("front_left_wheel", 0.1), wheel("rear_left_wheel", 0.4)))
    contract = PhaseMean("contract", 8.0, (wheel("front_left_wheel", 0.4), wheel("rear_left_wheel", 0.1)))
    return DrawbarPoint(pull, 0.02, pull, (expand, contract))


def test_axles_are_told_apart_by_whether_they_stand():
    assert thrust_over_load(point(0.2), stands=True) == pytest.approx(0.4)
    assert thrust_over_load(point(0.2), stands=False) == pytest.approx(0.1)


def test_the_figure_shows_both_wheels_and_both_axles(tmp_path):
    curve = Curve(CurveOrder("scarab", "inching", "rigid", "rft"), 2700.0, (point(0.1), point(0.2)))
    figure = glass_figure(VIEWS, [curve])
    roses, shares, thrust = (figure.axes[k] for k in (0, 2, 3))
    assert roses.name == "polar"
    assert sorted(bar.get_height() for bar in shares.patches) == pytest.approx([0.4, 0.41, 0.7, 0.72])
    drawn = [line.get_ydata() for line in thrust.lines[:2]]
    assert drawn[0] == pytest.approx([0.1, 0.1])
    assert drawn[1] == pytest.approx([0.4, 0.4])
    write_glass_table(VIEWS, tmp_path / "glass.csv")
    rows = list(csv.DictReader((tmp_path / "glass.csv").open()))
    assert [(row["wheel"], row["way"], float(row["along_thrust"])) for row in rows][2] == (
        "pushed",
        "measured",
        0.7,
    )


def test_a_folder_that_is_no_run_is_refused(tmp_path):
    with pytest.raises(GlassError, match=r"no scene\.toml: a run folder of softbed is needed"):
        both([tmp_path])
