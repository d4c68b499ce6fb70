"""A suite goes on where it was stopped, tells what failed, and ends in one table."""

import csv
import json

import numpy as np
import pytest
import xarray as xr

from validation.suites.execution import Task, carry_out, carry_out_task, measured_file
from validation.suites.gathered import gather
from validation.suites.measurement_file import open_measurement
from validation.suites.plan import Look, Motion, Realisation, Suite
from validation.suites.results import results_table, write_results
from validation.terminal import Terminal

MOTION = Motion("sand_rotation", seed=1, quick=True)
SUITE = Suite(
    "small",
    "one motion, two sets of pictures",
    tuple(Realisation(MOTION, seed, pair_count=1) for seed in (0, 1)),
    ("farneback",),
)


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    """The folder of the small suite, carried out by a process of its own."""
    folder = tmp_path_factory.mktemp("suite")
    assert carry_out(SUITE, folder, processes=1, terminal=Terminal()) == []
    return folder


def test_measurements(out):
    lines = gather(SUITE, out).lines
    every = [line for line in lines if line["stratum"] == "all"]
    assert [line["picture_seed"] for line in every] == [0, 1]
    assert all(0 < line["median"] < 0.2 and line["coverage"] > 0.9 for line in every)
    assert every[0]["median"] != every[1]["median"]
    assert not list(out.glob(".partial-*"))


def test_profile_counts_every_pixel_once(out):
    with open_measurement(measured_file(out, SUITE.looks[0])) as measured:
        counted = measured["count_speed"].sum() + measured["unmeasured_speed"].sum()
        assert counted == measured["pixel_count"].sel(stratum="all").sum()


def test_does_only_what_is_missing(out):
    paths = [measured_file(out, look) for look in SUITE.looks]
    before = [path.stat().st_mtime_ns for path in paths]
    whole = paths[1].read_bytes()
    for length in (1000, len(whole) - 1000):  # cut short
        paths[1].write_bytes(whole[:length])
        assert len(gather(SUITE, out).lines) == 5  # strata of the other one
    (out / ".partial-killed").mkdir()
    assert carry_out(SUITE, out, processes=1, terminal=Terminal()) == []
    assert not list(out.glob(".partial-*"))
    after = [path.stat().st_mtime_ns for path in paths]
    assert after[0] == before[0] and after[1] != before[1]


def test_a_failure_keeps_nothing_else_from_being_done(tmp_path):
    pictures = Realisation(MOTION, pair_count=1)
    looks = tuple(Look(pictures, method) for method in ("no-such-method", "farneback"))
    (tmp_path / "measured").mkdir()
    (failure,) = carry_out_task(Task(tmp_path, MOTION, looks))
    assert "no-such-method" in failure.name and "no-such-method" in failure.reason
    assert measured_file(tmp_path, looks[1]).is_file()


def test_a_motion_that_cannot_be_had(tmp_path):
    motion = Motion("no_such_scene")
    (failure,) = carry_out_task(Task(tmp_path, motion, (Look(Realisation(motion), "dis"),)))
    assert "no_such_scene" in failure.reason


def test_results(out):
    document = write_results(SUITE, out, [], command="softbed suite small OUT")
    assert document == json.loads((out / "small.json").read_text())
    (headline,) = [one for one in document["headlines"] if one["stratum"] == "all"]
    interval = headline["errors"]["median"]
    assert interval["low"] < interval["value"] < interval["high"]
    assert interval["realisation_count"] == 2
    with (out / "small.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(gather(SUITE, out).lines) and rows[0]["method"] == "farneback"
    with xr.open_dataset(out / "small.nc", engine="h5netcdf") as table:
        assert np.isfinite(table["median"][0]) and table["median"].attrs["units"] == "px"
    assert results_table(document).row_count == 2  # all, moving: no complex flow in a rotation


def test_command(softbed, tmp_path):
    status, _, err = softbed("suite", "everything", tmp_path)
    assert status == 2 and "allowed are smoke" in err
