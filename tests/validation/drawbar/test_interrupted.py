"""A curve that was interrupted is gone on with."""

import itertools
import json
from dataclasses import replace

import numpy as np
import pytest

from synth.rover.drawbar import LoadSteps
from validation.cli import run_command
from validation.drawbar.curve import CurveOrder
from validation.drawbar.experiment import CURVES, made_by, measure
from validation.drawbar.interrupted import Begun, find_begun, keep_begun
from validation.run_folder import RunFolder

LOADS = ("--load", "0.05", "--load", "0.1")
ORDER = CurveOrder("rocker_bogie", "rolling", "rigid", "rft", LoadSteps(loads=(0.05, 0.1)), speed=1.0)
COMMAND = ("--vehicle", "rocker_bogie", "--gait", "rolling", "--wheel", "rigid", "--speed", "1.0", *LOADS)


@pytest.fixture(scope="module")
def measured():
    """After each of the three points."""
    return list(measure(ORDER))


def test_what_was_begun_survives_and_only_for_the_same(tmp_path, measured):
    path = tmp_path / "begun.npz"
    assert find_begun(path, ORDER, {"softbed": "1"}) == (None, "")
    keep_begun(path, measured[0], {"softbed": "1"})
    found, unfit = find_begun(path, ORDER, {"softbed": "1"})
    assert found.curve == measured[0].curve and unfit == ""
    assert found.state.keys() == measured[0].state.keys()
    for name, value in measured[0].state.items():
        np.testing.assert_array_equal(found.state[name], value)
    for order, by in ((ORDER, {"softbed": "2"}), (replace(ORDER, speed=0.5), {"softbed": "1"})):
        found, unfit = find_begun(path, order, by)
        assert found is None and "begun anew" in unfit


@pytest.mark.parametrize(
    "damage", [lambda told: told[: len(told) // 2], lambda told: b"", lambda told: b"x" * 99]
)
def test_a_damaged_file_is_told_and_not_used(tmp_path, measured, damage):
    path = tmp_path / "begun.npz"
    keep_begun(path, measured[0], {})
    path.write_bytes(damage(path.read_bytes()))
    found, unfit = find_begun(path, ORDER, {})
    assert found is None and unfit.startswith("begun.npz: cannot be read")


def test_the_command_goes_on_after_the_last_load(tmp_path, capsys, measured):
    """Its first point, which nothing measures anew, is altered: it comes back."""
    first = measured[0].curve
    marked = replace(first, points=(replace(first.points[0], velocity=0.9 * first.points[0].velocity),))
    with RunFolder.create(tmp_path):
        (tmp_path / CURVES).mkdir()
        begun = tmp_path / CURVES / f".begun-{ORDER.name}.npz"
        keep_begun(begun, Begun(marked, measured[0].state), made_by(ORDER))
    assert run_command(["drawbar", str(tmp_path), *COMMAND, "--json"]) == 0
    told = capsys.readouterr()
    assert "rolling-rigid-rft: goes on, 1 of its points measured" in told.err
    assert not begun.exists()
    kept = json.loads((tmp_path / CURVES / f"{ORDER.name}.json").read_text())["points"]
    assert kept[0]["velocity"] == marked.points[0].velocity
    expected = [point.velocity for point in itertools.islice(measured[2].curve.points, 1, None)]
    assert [point["velocity"] for point in kept[1:]] == expected
