"""What a suite measures, and what its results are named and keyed by."""

from dataclasses import replace

import pytest

from synth.scene import scene_names
from validation.suites.catalogue import SUITES, SuiteError, find_suite
from validation.suites.plan import Look, Motion, Realisation
from validation.suites.severities import SeverityError, severity_changes

MADE_BY = {"softbed": "1"}
PICTURES = Realisation(Motion("sand_rotation", quick=True))


@pytest.mark.parametrize("quick", [False, True])
@pytest.mark.parametrize("name", SUITES)
def test_every_scene_can_be_had_and_every_name_is_its_own(name, quick):
    suite = find_suite(name, quick=quick)
    assert len({look.name for look in suite.looks}) == len(suite.looks)
    for realisation in suite.realisations:
        scene = realisation.scene()
        assert scene.simulation_hash == realisation.motion.load().simulation_hash
        assert scene.timing.frame_count > realisation.frames[-1]


def test_no_suite_uses_what_methods_were_tuned_on():
    for name in SUITES:
        assert all(r.motion.seed not in (0, 101) for r in find_suite(name).realisations)


@pytest.mark.parametrize("quick", [False, True])
def test_headline_rows_rest_on_eight_realisations(quick):
    suite = find_suite("complex", quick=quick)
    for scene in {r.motion.scene for r in suite.realisations}:
        own = [r for r in suite.realisations if r.motion.scene == scene and r.is_usual]
        headline = "paper" if any(r.severity == "paper" for r in own) else "clean"
        assert len({(r.motion.seed, r.picture_seed) for r in own if r.severity == headline}) == 8


def test_complex_looks_at_every_shipped_scene():
    assert set(scene_names()) == {r.motion.scene for r in find_suite("complex").realisations}


def test_slow_methods_see_a_part_of_the_pictures_and_all_where_they_are_asked_for():
    suite = find_suite("complex", quick=True)
    seen = {look.realisation for look in suite.looks if look.method == "soft-2014"}
    assert {r.motion.scene for r in seen} == {r.motion.scene for r in suite.realisations}
    assert len(seen) < len(suite.realisations)
    asked = suite.with_methods(["soft-2014"])
    assert sum(look.method == "soft-2014" for look in asked.looks) == len(suite.realisations)
    assert len({look.name for look in asked.looks}) == len(asked.looks)


@pytest.mark.parametrize(
    "other",
    [
        Look(replace(PICTURES, picture_seed=1), "dis"),
        Look(replace(PICTURES, pair_count=2), "dis"),
        Look(replace(PICTURES, motion=replace(PICTURES.motion, seed=3)), "dis"),
        Look(PICTURES, "farneback"),
        Look(PICTURES, "dis", pair_count=1),
    ],
)
def test_whatever_changes_a_result_changes_its_key(other):
    assert other.key(MADE_BY) != Look(PICTURES, "dis").key(MADE_BY)
    assert Look(PICTURES, "dis").key({"softbed": "2"}) != Look(PICTURES, "dis").key(MADE_BY)


def test_another_motion_has_other_pictures():
    seeds = {
        replace(PICTURES, motion=replace(PICTURES.motion, seed=seed)).scene().picture_seed for seed in (1, 2)
    }
    assert len(seeds) == 2


def test_severity():
    wheel = Realisation(Motion("rolling_wheel", quick=True), severity="heavy")
    assert wheel.scene().nuisance.vibration == 2.0
    assert replace(wheel, severity="clean").scene().nuisance.vibration == 0
    with pytest.raises(SeverityError, match="'worst': allowed are clean"):
        severity_changes("worst")


def test_severity_paper_is_as_noisy_whatever_the_sensor_is_told_in():
    plate, band = (
        Realisation(Motion(name, quick=True), severity="paper").scene()
        for name in ("plate_rotation", "shear_band")
    )
    levels = 255 * plate.sensor.read_noise / plate.sensor.full_well
    assert 5 < levels < 7
    clean = Realisation(Motion("shear_band", quick=True)).scene().sensor.noise
    assert band.sensor.noise == pytest.approx((levels**2 + clean**2) ** 0.5, abs=0.01)


def test_a_further_method_joins_once():
    suite = find_suite("smoke").with_methods(["my.flow:of", "dis"])
    assert suite.methods == ("dis", "farneback", "my.flow:of")


def test_unknown_suite():
    with pytest.raises(SuiteError, match="'all': allowed are smoke"):
        find_suite("all")
