"""What the suite `paper` measures is what it says, on motion that is known; its page shows it."""

import csv
import re
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from validation.suites.execution import carry_out
from validation.suites.paper import piv
from validation.suites.paper.bucket import pile_shares
from validation.suites.paper.found import Found
from validation.suites.paper.plan import METHODS, SERIES, paper_suite
from validation.suites.paper.regions import MovingSoil
from validation.suites.paper.rotation import counts_of
from validation.suites.paper.speed import variance_of
from validation.suites.paper.verdict import JUDGED, Variant
from validation.suites.results import write_results
from validation.terminal import Terminal

TINY = (("camera", "width", 120), ("camera", "height", 110), ("camera", "supersampling", 4))


@pytest.fixture(scope="module")
def suite():
    """One pair of pictures of a small plate, at both severities."""
    chosen = [
        replace(one, motion=replace(one.motion, changes=TINY, label="tiny"))
        for one in paper_suite(quick=True).realisations
        if one.motion.scene == piv.SCENE and one.picture_seed == 0
    ]
    return replace(paper_suite(quick=True), realisations=tuple(chosen), methods=(JUDGED.method,))


@pytest.fixture(scope="module")
def out(suite, tmp_path_factory):
    """Its folder, carried out by a process of its own."""
    folder = tmp_path_factory.mktemp("paper")
    assert carry_out(suite, folder, processes=1, terminal=Terminal()) == []
    return folder


def test_every_experiment_has_pictures_and_full_sets_are_larger():
    for quick in (False, True):
        realisations = paper_suite(quick).realisations
        assert {one.motion.scene for one in realisations} == {series.scene for series in SERIES}
        assert {one.severity for one in realisations} == {"paper", "clean"}
    pairs = [sum(one.pair_count for one in paper_suite(quick).realisations) for quick in (False, True)]
    assert pairs[0] > 5 * pairs[1]


def test_a_method_of_the_users_sees_everything():
    suite = paper_suite(quick=True).with_methods(["dis"])
    seen = {look.realisation for look in suite.looks if look.method == "dis"}
    assert seen == set(suite.realisations)


def test_counts_are_of_the_errors_in_the_table(suite, out):
    with Found.of(suite, out) as found:
        counted = counts_of(found, piv.SCENE, JUDGED)
        pixels = sum(
            float((one["pixel_count"] * one["coverage"]).sel(stratum="all").sum())
            for one in found.measurements(piv.SCENE, JUDGED)
        )
        assert counted.sum() == pytest.approx(pixels)
        noisy, clean = (
            found.mean(piv.SCENE, Variant(JUDGED.method, severity), "median", "all").value
            for severity in ("paper", "clean")
        )
        assert noisy > 2 * clean > 0


def test_results(suite, out):
    document = write_results(suite, out, [], command="softbed suite paper OUT")
    told = {(line["experiment"], line["quantity"], line["case"]): line for line in document["verdicts"]}
    median = told["rotation", "median", "GRC-1"]
    assert median["published"] == 0.15 and 0 < median["value"] < 1 and median["realisations"] == 1
    assert {line["verdict"] for line in told.values()} <= {"reproduced", "differs"}
    with (out / "paper-verdicts.csv").open(encoding="utf-8") as file:
        lines = list(csv.DictReader(file))
    assert {line["severity"] for line in lines} == {"paper", "clean"}
    assert sum(line["judged"] == "1" for line in lines) == len(told)
    page = (out / "paper.html").read_text(encoding="utf-8")
    assert not re.search(r'(src|href)="(?!data:|#)', page)
    assert all(f'id="{name}"' in page for name in ("rotation", "piv", "again"))
    assert document["verdict"] in page and METHODS[0] in page


def test_windows_are_found_where_they_went():
    generator = np.random.default_rng(1)
    first = np.kron(generator.uniform(0, 255, (40, 40)), np.ones((3, 3))).astype(np.float32)
    second = np.roll(first, (4, -7), axis=(0, 1))
    found = piv.match_windows(first, second, side=21)
    told = found[np.isfinite(found).all(axis=2)]
    assert len(told) >= 15
    assert np.median(told, axis=0) == pytest.approx([-7, 4], abs=0.05)
    rows, columns = np.nonzero(np.isfinite(found[..., 0]))
    assert set(rows) <= set(range(10, 120, 21)) and set(columns) <= set(range(10, 120, 21))


def test_pile():
    displacement = np.zeros((30, 90, 2))
    displacement[..., 0] = 1.0  # forward, but for the rear's upper row
    displacement[:, :30, 1], displacement[:, 60:, 1] = 0.5, -0.5
    displacement[0, :15, 0] = -1.0
    moving = np.ones((30, 90), bool)
    shares = pile_shares(MovingSoil(displacement, moving, moving))
    assert shares["forward"] == pytest.approx(1 - 15 / 2700)
    assert shares["fore_up"] > 0.95 and shares["rear_down"] > 0.95
    nothing = pile_shares(MovingSoil(displacement, moving, ~moving))
    assert np.isnan(list(nothing.values())).all()


def test_variance_with_its_interval():
    generator = np.random.default_rng(2)
    told = variance_of([generator.normal(5.0, 0.3, 400)])
    assert told.low < 0.09 < told.high and told.high < 0.12


def test_a_table_holds_what_a_page_needs(suite, out):
    with xr.open_dataset(out / "paper.nc", engine="h5netcdf") as table:
        assert set(table["method"].values) == {JUDGED.method, *piv.METHODS.values()}
