"""The rule by which a method counts as worse than its baseline."""

from dataclasses import replace

import numpy as np
import pytest

from validation.gate.measurement import GateError, Measurement, PairScore
from validation.gate.verdict import QUANTITIES, compare
from validation.scoring.strata import STRATA

CLIPS = [f"clip-{k}" for k in range(10)]


def measurement(change=lambda clip, stratum, score: score):
    """Ten clips of two pairs, each as hard as its number says; `complex` is missing from three of them."""
    clips = {}
    for number, clip in enumerate(CLIPS):
        strata = [s for s in STRATA if number >= 3 or s != "complex"]
        score = PairScore(0.99, 0.03 + 0.01 * number, 0.2 + 0.05 * number, 0.05 + 0.03 * number)
        clips[clip] = [{s: change(clip, s, score) for s in strata} for _ in range(2)]
    return Measurement("a method", "digest", clips, {})


def scattered(seed, factor=1.0, points=0.0, stratum=None, scatter=0.03):
    """Change errors by a factor and shares by points, in one stratum or all, with a scatter between clips."""
    random = np.random.default_rng(seed)

    def change(clip, at, score):
        here = stratum in (None, at)
        by = (factor if here else 1.0) * np.exp(random.normal(0, scatter))
        return replace(
            score,
            median=score.median * by,
            p95=score.p95 * by,
            wrong_share=score.wrong_share + (points if here else 0.0) + random.normal(0, 0.005),
        )

    return measurement(change)


def worse(before, after):
    return {(row.stratum, row.quantity) for row in compare(before, after) if row.worse}


def test_nothing_changed():
    assert worse(measurement(), measurement()) == set()


@pytest.mark.parametrize("stratum", STRATA)
@pytest.mark.parametrize("seed", range(5))
def test_finds_a_tenth_of_the_median(stratum, seed):
    assert (stratum, "median") in worse(measurement(), scattered(seed, factor=1.1, stratum=stratum))


@pytest.mark.parametrize("stratum", STRATA)
@pytest.mark.parametrize("seed", range(5))
def test_finds_five_points_of_the_wrong_share(stratum, seed):
    found = worse(measurement(), scattered(seed, points=0.05, stratum=stratum))
    assert found == {(stratum, "wrong_share")}


@pytest.mark.parametrize("seed", range(20))
def test_scatter_alone_passes(seed):
    assert worse(measurement(), scattered(seed)) == set()


def test_a_better_method_passes():
    assert worse(measurement(), scattered(1, factor=0.5, points=-0.04)) == set()


def test_small_but_certain_changes_are_tolerated():
    slightly = {q.name: q.tolerance * 0.8 for q in QUANTITIES}

    def change(_, __, score):
        return replace(
            score,
            median=score.median * (1 + slightly["median"]),
            p95=score.p95 * (1 + slightly["p95"]),
            wrong_share=score.wrong_share + slightly["wrong_share"],
        )

    assert worse(measurement(), measurement(change)) == set()


def test_a_single_clip_is_enough():
    def change(clip, stratum, score):
        return replace(score, median=1.3 * score.median) if (clip, stratum) == ("clip-5", "moving") else score

    rows = [row for row in compare(measurement(), measurement(change)) if row.worse]
    assert [(row.stratum, row.quantity, row.reason) for row in rows] == [("moving", "median", "on clip-5")]
    assert rows[0].worst_change == pytest.approx(0.3, rel=0.03)  # the floor of 0.001 px takes some of it


def test_unmeasured_pixels_count_as_wrong():
    def change(_, stratum, score):
        nothing = replace(score, coverage=0.0, median=None, p95=None, wrong_share=1.0)
        return nothing if stratum == "complex" else score

    found = worse(measurement(), measurement(change))
    assert found == {("complex", "wrong_share")}


def test_other_clips_are_refused():
    with pytest.raises(GateError, match="other clips"):
        compare(measurement(), replace(measurement(), clips_digest="another"))


def test_baseline_file(tmp_path):
    before = measurement()
    before.write(tmp_path / "deep" / "baseline.json")
    assert Measurement.read(tmp_path / "deep" / "baseline.json") == before


SCORE = '{"coverage": 1, "median": %s, "p95": 0.2, "wrong_share": 0}'
ONE_CLIP = '{"schema_version": 1, "method": "a", "clips_digest": "b", "versions": {}, "clips": {"x": %s}}'


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("", "Expecting value"),
        ("[]", "a JSON object is needed"),
        ("3", "a JSON object is needed"),
        ("{}", "schema_version: missing"),
        ('{"schema_version": 2}', "schema_version = 2: this program reads 1"),
        ('{"schema_version": 1}', "method: missing"),
        (ONE_CLIP % "3", r"clips\.x = 3: a list is needed"),
        (ONE_CLIP % "[[]]", r"clips\.x\.0: a JSON object is needed"),
        (ONE_CLIP % '[{"all": {}}]', r"clips\.x\.0\.all\.coverage: missing"),
        (ONE_CLIP % f'[{{"all": {SCORE % "NaN"}}}]', r"clips\.x\.0\.all\.median = NaN: .*finite number"),
        (ONE_CLIP % f'[{{"all": {SCORE % "[]"}}}]', r"clips\.x\.0\.all\.median: a number is needed"),
    ],
)
def test_what_is_no_baseline(tmp_path, content, told):
    path = tmp_path / "baseline.json"
    path.write_text(content)
    with pytest.raises(GateError, match=rf"baseline\.json: not a baseline: {told}"):
        Measurement.read(path)
