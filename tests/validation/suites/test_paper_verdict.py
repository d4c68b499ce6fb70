"""Published numbers are read with their bounds, and judged by the rule that the page states."""

import csv
import json

import numpy as np
import pytest

from validation.published import REFERENCE_FOLDER, Published, read_published
from validation.statistics import Interval
from validation.suites.paper.conclusion import experiments
from validation.suites.paper.drawbar import EXPERIMENT as DRAWBAR
from validation.suites.paper.drawbar import read_maxima, told_by
from validation.suites.paper.verdict import (
    DIFFERS,
    NOT_MEASURED,
    REPRODUCED,
    difference,
    judge,
    our_words,
    published_words,
    ratio,
    reason,
)

PUBLISHED = Published("p95", 0.30, "px", "Fig. 8", 0.28, 0.31, "95 % error")


def interval(value, half=np.nan):
    return Interval(value, value - half, value + half, 4, 16)


@pytest.mark.parametrize(
    ("ours", "verdict"),
    [
        (interval(0.30, 0.01), REPRODUCED),
        (interval(0.35, 0.05), REPRODUCED),  # touches
        (interval(0.35, 0.03), DIFFERS),
        (interval(0.20, 0.05), DIFFERS),
        (interval(0.29), REPRODUCED),  # without an interval
        (interval(0.27), DIFFERS),
        (interval(np.nan), NOT_MEASURED),
        (None, NOT_MEASURED),
    ],
)
def test_rule(ours, verdict):
    assert judge(PUBLISHED, ours) == verdict


def test_reason_says_on_which_side_by_how_much_and_why():
    causes = {("p95", "above"): "noise"}
    assert reason(PUBLISHED, interval(0.35, 0.03), causes) == "above by 0.01 px; noise"
    assert reason(PUBLISHED, interval(0.2, 0.03), causes) == "below by 0.05 px"
    assert reason(PUBLISHED, interval(0.3, 0.03), causes) == ""
    assert reason(PUBLISHED, interval(0.2), {}, 0.21).endswith("so does the truth of these pictures")
    assert reason(PUBLISHED, interval(0.2), {}, 0.3).endswith("the truth of these pictures does not")


def test_difference_and_ratio_of_independent_numbers():
    told = difference(interval(5.0, 0.3), interval(3.0, 0.4))
    assert (told.value, told.high - told.value) == pytest.approx((2.0, 0.5))
    told = ratio(interval(4.0, 0.4), interval(2.0, 0.0))
    assert (told.low, told.value, told.high) == pytest.approx((2 / 1.1, 2.0, 2.2))


def test_words():
    assert published_words(PUBLISHED) == "0.3 (0.28 to 0.31)"
    assert published_words(Published("n", 10, "1", "", 10, np.inf)) == "at least 10"
    assert published_words(Published("n", np.nan, "1", "", 0.9, 1)) == "0.9 to 1"
    assert our_words(interval(0.25, 0.01)) == "0.250 (0.240 to 0.260)"
    assert our_words(interval(3.14159)) == "3.14"


@pytest.mark.parametrize("experiment", [*experiments(), DRAWBAR], ids=lambda one: one.name)
def test_every_quantity_is_published_with_its_place_and_in_words(experiment):
    published = read_published(experiment.table)
    for quantity in experiment.quantities:
        one = published[quantity]
        assert one.where and one.says
        assert one.low <= one.high
        assert np.isnan(one.value) or one.low <= one.value <= one.high
    assert {quantity for quantity, _ in experiment.causes} <= set(experiment.quantities)


def test_tables_name_their_source():
    for path in REFERENCE_FOLDER.glob("*.csv"):
        assert path.read_text(encoding="utf-8").startswith(("# Source: ", "# Sources:")), path.name
        rows = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
        assert len({len(row) for row in csv.reader(rows)}) == 1, path.name


@pytest.mark.parametrize("content", ["", "[]", "{}", '{"curves": 3}', '{"curves": [{"law": "rft"}]}'])
def test_what_is_no_drawbar_document(tmp_path, content):
    path = tmp_path / "drawbar.json"
    path.write_text(content)
    with pytest.raises(ValueError, match=r"drawbar\.json: not what softbed drawbar writes"):
        read_maxima(path)


def test_drawbar_pull_by_gait_and_wheel(tmp_path):
    curves = [
        {"gait": "rolling", "wheel": "rigid", "law": "rft", "maximum": 0.2},
        {"gait": "inching", "wheel": "rigid", "law": "rft", "maximum": 0.3},
        {"gait": "inching", "wheel": "rigid", "law": "bwj", "maximum": 0.9},
        {"gait": "rolling", "wheel": "pneumatic", "law": "rft", "maximum": 0.1, "maximum_reached": False},
    ]
    path = tmp_path / "drawbar.json"
    path.write_text(json.dumps({"curves": curves}))
    told = {one.quantity: one.interval.value for one in told_by(read_maxima(path))}
    assert told == pytest.approx({"rolling_rigid": 0.2, "inching_rigid": 0.3, "gain_rigid": 1.5})
