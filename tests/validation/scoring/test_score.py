import json

import numpy as np
import pytest

from validation.scoring.method_scores import score_methods
from validation.scoring.score import MethodScore, ScoreError, Scores

SHAPE = (20, 30)


@pytest.fixture
def footage(make_truth, make_footage):
    u = np.zeros(SHAPE, np.float32)
    u[:, :5] = 4.0
    return make_footage(make_truth(u, 0.0), make_truth(u, 0.0))


@pytest.fixture
def flow_of(make_flow):
    def flow_of(footage, *, off=(0.0, 0.0)):
        u = np.stack([footage.truth(k)["u"].values + np.float32(off[0]) for k in range(footage.pair_count)])
        return make_flow(u, np.full_like(u, off[1]))

    return flow_of


def strata_of(footage, flow):
    return score_methods(footage, {"own": flow})["own"].strata


def test_the_truth_itself_is_right(footage, flow_of):
    strata = strata_of(footage, flow_of(footage))
    assert strata["all"].pixel_count == 2 * 20 * 30
    assert strata["moving"].pixel_count == 2 * 20 * 5
    assert strata["complex"].pixel_count == 2 * 20 * 8  # the jump, and 3 px to either side
    assert strata["quiet"].pixel_count == 2 * 20 * 21
    assert strata["mixed"].pixel_count == 0 and strata["mixed"].median is None
    for name in ("all", "moving", "complex", "quiet"):
        assert strata[name].p95 == 0 and strata[name].coverage == 1


def test_an_offset_is_found_with_its_sign(footage, flow_of):
    summary = strata_of(footage, flow_of(footage, off=(0.5, -0.25)))["all"]
    assert (summary.bias_u, summary.bias_v) == (pytest.approx(0.5), pytest.approx(-0.25))
    assert summary.median == pytest.approx(np.hypot(0.5, 0.25))


def test_every_method_is_judged_on_the_same_pixels(footage, flow_of):
    lazy = flow_of(footage)
    lazy["u"][:, :, 15:] = np.nan
    lazy["valid"][:, :, 15:] = False
    scores = score_methods(footage, {"full": flow_of(footage), "lazy": lazy})
    full, half = (scores[name].strata["all"] for name in ("full", "lazy"))
    assert full.pixel_count == half.pixel_count
    assert half.coverage == 0.5
    assert half.wrong_share["1.0"] == 0.5


def test_the_mask_counts_and_not_what_lies_beneath(footage, flow_of):
    flow = flow_of(footage)
    flow["valid"][:] = False
    assert strata_of(footage, flow)["all"].coverage == 0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda flow: flow.isel(x=slice(10)), "10 x 20 px, but the footage has 30 x 20 px"),
        (lambda flow: flow.isel(pair=[0]), "1 picture pairs, but the footage has 2"),
        (lambda flow: flow.assign_coords(first_frame=("pair", [0, 2])), "not the footage's consecutive ones"),
        (
            lambda flow: flow.assign_attrs(camera="rigid (as it once was)"),
            "camera = 'rigid': allowed are median, mode, far: analyze again",
        ),
    ],
)
def test_flow_of_other_pictures_is_refused(footage, flow_of, change, words):
    with pytest.raises(ScoreError, match=words):
        score_methods(footage, {"own": change(flow_of(footage))})


def test_scores_on_disk(footage, flow_of, tmp_path):
    strata = strata_of(footage, flow_of(footage))
    scores = Scores("scene", 3, True, {"own": MethodScore(0.5, strata)}, {"softbed": "0"})
    path = tmp_path / "scores.json"
    scores.write(path)
    assert Scores.read(path) == scores
    content = json.loads(path.read_text())
    assert list(content) == ["schema_version", "scene", "seed", "quick", "versions", "methods"]
    assert list(content["methods"]["own"]["strata"]["all"]) == [
        "pixel_count", "coverage", "median", "mean", "p95", "rmse", "bias_u", "bias_v", "wrong_share",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", "Expecting value"),
        ("[]", "a JSON object is needed"),
        ('{"schema_version": 2}', "schema_version = 2: this program reads 1"),
        ('{"schema_version": 1, "scene": "s", "seed": 0, "quick": true, "versions": {}}', "methods: missing"),
    ],
)
def test_what_is_not_scores_is_refused(tmp_path, content, words):
    (tmp_path / "scores.json").write_text(content)
    with pytest.raises(ScoreError, match=rf"scores\.json: not scores: {words}"):
        Scores.read(tmp_path / "scores.json")


@pytest.mark.parametrize(
    ("harm", "words"),
    [
        (lambda own: own.pop("strata"), "methods.own.strata: missing"),
        (lambda own: own["strata"]["all"].pop("median"), "methods.own.strata.all.median: missing"),
        (lambda own: own["strata"]["all"].update(p95="far"), 'methods.own.strata.all.p95 = "far": '),
        (lambda own: own.update(camera=[]), "methods.own.camera: a JSON object is needed"),
        (lambda own: own.update(soil_iou=1.0), "methods.own.moving_iou: missing"),
        (lambda own: own.update(averaging={"pair_count": [1]}), "methods.own.averaging.error: missing"),
    ],
)
def test_damage_is_told_by_its_key(footage, flow_of, tmp_path, harm, words):
    path = tmp_path / "scores.json"
    own = MethodScore(0.5, strata_of(footage, flow_of(footage)))
    Scores("scene", 3, True, {"own": own}, {}).write(path)
    content = json.loads(path.read_text())
    harm(content["methods"]["own"])
    path.write_text(json.dumps(content))
    with pytest.raises(ScoreError, match=f"not scores: {words}"):
        Scores.read(path)
