"""The suite's fast cases, that they can fail, and what the command line says of them."""

import json
from dataclasses import replace

import numpy as np
import pytest

from synth.dem.grains import Grains
from synth.devices import start_taichi
from validation.verification import collisions, sliding_and_rolling, suite
from validation.verification.column_collapse import heap
from validation.verification.comparison import compare, compare_with_bounds

ROW = {"case", "quantity", "reference", "measured", "relative_error", "limit", "low", "high"}
ROW |= {"passed", "source"}


@pytest.fixture(autouse=True)
def taichi():
    start_taichi()


@pytest.mark.parametrize("name", suite.FAST)
def test_fast_case(name):
    failed = [comparison for comparison in suite.FAST[name]() if not comparison.passed]
    assert not failed, failed


def test_error_is_relative_to_the_reference_or_to_a_scale():
    row = compare("length, m", reference=-2.0, measured=-2.1, limit=0.1, source="")
    assert row.relative_error == pytest.approx(0.05)
    assert row.passed
    row = compare("length, m", reference=0.0, measured=0.3, scale=2.0, limit=0.1, source="")
    assert row.relative_error == pytest.approx(0.15)
    assert not row.passed


def test_not_a_number_keeps_no_limit():
    assert not compare("length, m", reference=1.0, measured=np.nan, limit=1e9, source="").passed


@pytest.mark.parametrize(("measured", "passed"), [(9.9, False), (10.1, True), (19.9, True), (20.1, False)])
def test_bounds(measured, passed):
    row = compare_with_bounds("angle, degrees", low=10.0, high=20.0, measured=measured, source="")
    assert row.passed is passed
    assert (row.low, row.high) == (10.0, 20.0)


@pytest.mark.parametrize(
    ("module", "case", "wrong"),
    [
        (collisions, collisions.rebound_from_floor, {"damping_ratio": 0.1}),
        (collisions, collisions.elastic_contact, {"normal_stiffness": 1.02e6}),
        (collisions, collisions.gross_sliding, {"wall_friction": 0.21}),
        (sliding_and_rolling, sliding_and_rolling.tangential_spring, {"tangential_stiffness": 0.52e6}),
        (sliding_and_rolling, sliding_and_rolling.sliding_to_rolling, {"wall_friction": 0.31}),
    ],
    ids=["restitution", "stiffness", "friction", "tangential stiffness", "rolling"],
)
def test_a_wrong_law_is_found_out(monkeypatch, module, case, wrong):
    right = module.law
    monkeypatch.setattr(module, "law", lambda **values: replace(right(**values), **wrong))
    assert not all(comparison.passed for comparison in case())


def test_heap_leaves_out_what_rolled_away():
    position = np.array([[0.0, 2e-3, 4e-3, 9e-3], [0.0, 0.0, 0.0, 0.0]])
    grains = Grains.at_rest(position, np.full(4, 1e-3), 2000.0)
    assert heap(grains).tolist() == [True, True, True, False]


def test_cases_are_chosen_by_name_in_the_order_of_the_suite():
    assert suite.choose_cases([], quick=False) == suite.CASES
    assert suite.choose_cases([], quick=True) == tuple(suite.FAST)
    assert suite.choose_cases(["creep", "rebound"], quick=False) == ("rebound", "creep")
    with pytest.raises(ValueError, match=r"case = 'wheel': allowed are rebound, .*janssen"):
        suite.choose_cases(["wheel"], quick=False)


def test_json_is_as_the_interface_says(softbed):
    status, output, error = softbed("verify", "dem", "--case", "elastic-contact", "--case", "creep", "--json")
    assert status == 0, error
    document = json.loads(output)
    assert document["schema_version"] == 1
    assert [row["case"] for row in document["rows"]] == ["elastic-contact", "elastic-contact", "creep"]
    assert all(set(row) == ROW and row["source"] for row in document["rows"])


def test_a_case_that_fails_makes_the_command_fail(softbed, monkeypatch):
    off = compare("length, m", reference=1.0, measured=2.0, limit=0.1, source="a ruler")
    monkeypatch.setitem(suite.FAST, "creep", lambda: [off])
    status, output, _ = softbed("verify", "dem", "--case", "creep")
    assert status == 1
    assert "FAILED" in output


def test_an_unknown_case_is_one_line(softbed):
    status, _, error = softbed("verify", "dem", "--case", "wheel")
    assert status == 2
    assert error.count("\n") == 1
    assert "wheel" in error
