"""Curves, their document and figures, and the command that goes on with what is there."""

import json

import numpy as np
import pytest

from synth.rover.balance import PhaseMean, WheelMean
from synth.rover.drawbar import DrawbarPoint, LoadSteps
from validation.cli import run_command
from validation.drawbar.curve import Curve, CurveOrder, orders_of
from validation.drawbar.document import drawbar_document, ratios
from validation.drawbar.experiment import CURVES, found_curve, made_by
from validation.run_folder import RunFolder

WHEELS = ("front_left_wheel", "rear_left_wheel", "front_right_wheel", "rear_right_wheel")
WEIGHT = 2746.8


def point(pull, reduction, phases):
    wheels = tuple(WheelMean(name, pull * WEIGHT / 4, WEIGHT / 4, -50.0, 0.5, 0.6, 0.03) for name in WHEELS)
    means = tuple(PhaseMean(phase, 8.0, wheels) for phase in phases)
    return DrawbarPoint(pull, 0.06 * (1 - reduction), reduction, means)


def curve(gait, *, wheel="rigid", standing=0.25, count=21):
    phases = ("roll",) if gait == "rolling" else ("expand", "contract")
    pulls = np.linspace(0, standing, count)
    points = [point(float(pull), float((pull / standing) ** 2), phases) for pull in pulls]
    (order,) = orders_of("scarab", gaits=[gait], wheels=[wheel])
    return Curve(order, WEIGHT, tuple(points))


def keep(curves, out):
    with RunFolder.create(out):
        (out / CURVES).mkdir()
        for one in curves:
            told = one.to_dict() | {"made_by": made_by(one.order)}
            (out / CURVES / f"{one.order.name}.json").write_text(json.dumps(told))


def test_maximum_is_where_nine_tenths_of_the_speed_are_lost():
    measured = curve("rolling", standing=0.2)
    assert measured.maximum == pytest.approx(0.2 * 0.9**0.5, rel=0.01)
    assert measured.reached
    assert measured.at_travel_reduction["0.4"] == pytest.approx(0.2 * 0.4**0.5, rel=0.01)
    short = Curve(measured.order, WEIGHT, measured.points[:11])
    assert not short.reached
    assert short.maximum == pytest.approx(0.1)
    assert short.at_travel_reduction["0.4"] is None


def test_ratio_of_the_gaits_stands_beside_the_published_one():
    (ratio,) = ratios([curve("rolling", standing=0.2), curve("inching", standing=0.3)])
    assert ratio.value == pytest.approx(1.5)
    assert ratio.at_travel_reduction["0.4"] == pytest.approx(1.5)
    assert ratio.published == pytest.approx(1.375)


def test_another_vehicle_has_no_published_maximum():
    measured = curve("rolling")
    other = Curve(CurveOrder("rocker_bogie", "rolling", "rigid", "rft"), WEIGHT, measured.points)
    document = drawbar_document([other])
    assert document["curves"][0]["published_maximum"] is None
    assert document["ratios"] == []


@pytest.mark.parametrize("content", ["", "[]", "{}", '{"made_by": {}}', '{"made_by": {}, "order": 3}'])
def test_a_curve_that_somebody_changed_is_not_there(tmp_path, content):
    whole = curve("rolling")
    keep([whole], tmp_path)
    assert found_curve(tmp_path / CURVES, whole.order) == whole
    (tmp_path / CURVES / f"{whole.order.name}.json").write_text(content)
    assert found_curve(tmp_path / CURVES, whole.order) is None


def test_curves_survive_json():
    measured = curve("inching")
    assert Curve.from_dict(json.loads(json.dumps(measured.to_dict()))) == measured


def test_the_command_goes_on_with_what_is_there(tmp_path, capsys):
    kept = [curve("rolling", standing=0.24), curve("inching", standing=0.32)]
    keep(kept, tmp_path)
    assert run_command(["drawbar", str(tmp_path), "--wheel", "rigid", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["schema_version"] == 1
    assert document["vehicle_weight"] == pytest.approx(WEIGHT)
    rolling, inching = document["curves"]
    assert (rolling["gait"], rolling["wheel"], rolling["law"]) == ("rolling", "rigid", "rft")
    expected = np.array([0.24, 0.32]) * 0.9**0.5
    assert (rolling["maximum"], inching["maximum"]) == pytest.approx(expected, rel=0.01)
    assert len(inching["points"]) == 21
    assert set(inching["at_travel_reduction"]) == {"0.1", "0.2", "0.4"}
    for name in ("drawbar.png", "balance.png", "drawbar.json", "drawbar.csv"):
        assert (tmp_path / name).stat().st_size > 0
    header, *rows = (tmp_path / "drawbar.csv").read_text().splitlines()
    assert header.startswith("gait,wheel_kind,law,drawbar_pull_ratio")
    assert len(rows) == 21 * 4 * 3


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--gait", "crawling"], "gait 'crawling'"),
        (["--wheel", "square"], "wheel = 'square'"),
        (["--law", "hertz"], "law = 'hertz'"),
        (["--soil", __file__], "the table 'soil' of softbed identify is needed"),
        (["--load", "0.2", "--load", "0.1"], "positive and rising"),
        (["--speed", "0"], "must be positive"),
        (["--vehicle", "lunokhod"], "lunokhod: neither an MJCF file nor a shipped vehicle"),
        (["--vehicle", "rocker_bogie"], "no actuator 'left_spread'"),
    ],
)
def test_bad_input_is_told_in_one_line(tmp_path, capsys, options, told):
    assert run_command(["drawbar", str(tmp_path / "out"), *options]) == 2
    error = capsys.readouterr().err
    assert told in error
    assert error.count("\n") == 1


@pytest.mark.slow
def test_a_curve_is_measured_in_a_process_of_its_own(tmp_path, capsys):
    command = ["drawbar", str(tmp_path), "--vehicle", "rocker_bogie", "--gait", "rolling", "--wheel", "rigid"]
    assert run_command([*command, "--speed", "0.3", "--load", "0.05", "--load", "0.1", "--json"]) == 0
    (measured,) = json.loads(capsys.readouterr().out)["curves"]
    reductions = [one["travel_reduction"] for one in measured["points"]]
    assert reductions[0] == 0
    assert 0 < reductions[1] < reductions[2] < 1


def test_an_order_with_steps_survives():
    order = CurveOrder("scarab", "inching", "pneumatic", "bwj", LoadSteps(loads=(0.1, 0.2)))
    assert CurveOrder.from_dict(json.loads(json.dumps(order.to_dict()))) == order


def test_a_film_of_a_gait_that_is_not_measured_is_refused_before_curves_are(tmp_path, capfd):
    assert run_command(["drawbar", str(tmp_path / "out"), "--gait", "rolling", "--film"]) == 2
    assert "--gait inching is needed" in capfd.readouterr().err
    assert not (tmp_path / "out").exists()
