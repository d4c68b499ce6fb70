"""Soil motion of both halves of push-rolling beside the rover's forces."""

import csv
import re
import shutil

import numpy as np
import pytest

from synth.rover.balance import PhaseMean, WheelMean
from synth.rover.drawbar import DrawbarPoint
from synth.scene import load_scene
from validation.cli import run_command
from validation.drawbar.curve import Curve, CurveOrder
from validation.drawbar.glass import (
    GlassView,
    Seen,
    glass_figure,
    runs_by_wheel,
    thrust_over_load,
    write_glass_table,
)
from validation.gate.measurement import SHIPPED_CLIPS


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


@pytest.fixture
def runs(tmp_path):
    """Folders that have what is looked for in a run of each wheel, with footage of anything."""

    def make(name, scene):
        folder = tmp_path / "runs" / name
        shutil.copytree(
            next(path.parent for path in sorted(SHIPPED_CLIPS.glob("*/truth.nc"))), folder / "footage"
        )
        (folder / "scene.toml").write_text(load_scene(scene, quick=True).to_toml())
        (folder / "forces.csv").write_text("time [s]\n")
        return folder

    wheels = {"rolling": "rolling_wheel", "slipping": "grouser_wheel", "pushed": "pushed_wheel"}
    return {name: make(name, scene) for name, scene in wheels.items()}


def test_runs_are_told_apart_by_how_their_wheels_are_driven(runs):
    found = runs_by_wheel([runs["pushed"], runs["rolling"]])
    assert list(found.items()) == [("rolling", runs["rolling"]), ("pushed", runs["pushed"])]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (["rolling"], "one of a pushed wheel are needed, not 1"),
        (["rolling", "slipping", "pushed"], "are both runs of a rolling wheel"),
        (["rolling", "nowhere"], r"nowhere: no scene\.toml: a run folder of softbed is needed"),
    ],
)
def test_runs_are_refused_before_curves_are_measured(runs, tmp_path, capfd, given, words):
    options = [word for name in given for word in ("--glass", str(runs.get(name, tmp_path / name)))]
    assert run_command(["drawbar", str(tmp_path / "out"), *options]) == 2
    assert re.search(words, capfd.readouterr().err)
    assert not (tmp_path / "out").exists()


def test_pictures_are_opened_before_curves_are_measured(runs):
    (runs["pushed"] / "footage" / "truth.nc").write_bytes(b"nothing")
    with pytest.raises(ValueError, match=r"truth\.nc"):
        runs_by_wheel([runs["rolling"], runs["pushed"]])
