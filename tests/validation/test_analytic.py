"""An analytic scene goes through the whole chain."""

import json

import pytest


@pytest.fixture(scope="module")
def scored(tmp_path_factory):
    from validation.cli import run_command

    out = tmp_path_factory.mktemp("analytic") / "out"
    assert run_command(["run", "shear_band", str(out), "--quick", "--method", "dis"]) == 0
    return out


def test_the_whole_chain(scored):
    scores = json.loads((scored / "scores.json").read_text())
    assert (scores["scene"], scores["quick"]) == ("shear_band", True)
    strata = scores["methods"]["dis"]["strata"]
    assert 0.98 * 400 * 240 < strata["all"]["pixel_count"] <= 400 * 240
    # The disc has a radius of 80 px, and moves by more than a pixel where r > 1 / 0.0375 = 27 px.
    assert strata["moving"]["pixel_count"] == pytest.approx(3.1416 * (80**2 - 27**2), rel=0.03)
    # The band's gradient 3 / 4 sech^2((r - 80) / 2) is above 0.1 px/px for |r - 80| < 3.3 px; and 3 px more.
    assert strata["complex"]["pixel_count"] == pytest.approx(2 * 3.1416 * 80 * 2 * 6.3, rel=0.06)
    assert strata["quiet"]["median"] < 0.05
    assert strata["complex"]["wrong_share"]["0.3"] > 3 * strata["quiet"]["wrong_share"]["0.3"]
    assert (scored / "report.html").stat().st_size > 100_000


def test_it_is_whole_and_done_once(softbed, scored):
    assert softbed("check", scored)[0] == 0
    status, _, error = softbed("run", "shear_band", scored, "--quick", "--method", "dis")
    assert status == 0 and error.count("skipped") == 5
    status, _, error = softbed("export", scored)
    assert status == 2 and "there are no grains to export" in error
