"""Sweep files, designs, and who shares what."""

import numpy as np
import pytest

from synth.dataset.design import points_of
from synth.dataset.execution import Asked
from synth.dataset.members import bed_key, deal_out, members_of
from synth.dataset.sweep import SPLITS, Split, Sweep, SweepError, load_sweep
from synth.scene import SceneError, changed_scene, load_scene

FILE = """
schema_version = 1
name = "slips"
scene = "rolling_wheel"
quick = true
[design]
kind = "sobol"
count = 8
[vary]
"drive.slip" = { low = 0.0, high = 0.5 }
lens.blur = [0.5, 1.0]
"""


def make_sweep(vary, *, kind="grid", **others):
    count = others.pop("count", None)
    tables = {"schema_version": 1, "name": "own", "scene": "rolling_wheel", "vary": vary, **others}
    return Sweep.model_validate({**tables, "design": {"kind": kind, "count": count}})


@pytest.fixture
def sweep_file(tmp_path):
    def write(old="", new=""):
        assert old in FILE
        path = tmp_path / "sweep.toml"
        path.write_text(FILE.replace(old, new) if old else FILE)
        return path

    return write


def test_a_file_is_read_with_its_scene(sweep_file):
    sweep, base = load_sweep(sweep_file())
    assert list(sweep.vary) == ["drive.slip", "lens.blur"]
    assert base.quick and base.name == "rolling_wheel"


@pytest.mark.parametrize(
    "old, new, words",
    [
        (
            "low = 0.0",
            "lo = 0.0",
            ["vary.drive.slip.lo: unknown key, allowed are count, high, integer, low, scale"],
        ),
        ("low = 0.0", "low = 0.7", ["vary.drive.slip: low < high is needed, got 0.7 and 0.5"]),
        ("high = 0.5", 'high = 0.5, scale = "log"', ["vary.drive.slip", "low > 0 is needed"]),
        ("high = 0.5", "high = 0.5, count = 3", ["vary.drive.slip", "'sobol' has no count"]),
        ("[0.5, 1.0]", "0.5", ["vary.lens.blur = 0.5", "a list of values, or a table"]),
        ("count = 8", "", ["design: kind = 'sobol': count missing"]),
        ("sobol", "halton", ["design.kind = 'halton'", "'latin_hypercube'"]),
        ("quick", "quik", ["quik: unknown key"]),
        ("schema_version = 1", "schema_version = 2", ["schema_version = 2", "1"]),
        ("[vary]", "[split]\ntrain = 0.5\n[vary]", ["split: train + validation + test = 1", "got 0.7"]),
        ('"rolling_wheel"', '"nowhere.toml"', ["scene = 'nowhere.toml'", "no such file"]),
        ("[design]", "[design", ["not TOML"]),
    ],
)
def test_faults_name_file_key_value_and_what_is_allowed(sweep_file, old, new, words):
    path = sweep_file(old, new)
    with pytest.raises(SweepError) as raised:
        load_sweep(path)
    assert all(word in str(raised.value) for word in [str(path), *words])


@pytest.mark.parametrize("key", ["drive.slipp", "lense.blur", "sed", "seed.x"])
def test_a_key_that_does_not_exist_is_refused_and_named(key):
    sweep = make_sweep({key: [0.1]}, quick=True)
    with pytest.raises(SweepError, match=key.partition(".")[0]):
        members_of(sweep, load_scene("rolling_wheel", quick=True))


@pytest.mark.parametrize(("shares", "empty"), [((0.8, 0.1, 0.1), ["validation", "test"]), ((1, 0, 0), [])])
def test_a_split_that_gets_no_member_is_told(shares, empty):
    split = Split(**dict(zip(SPLITS, shares, strict=True)))
    sweep = make_sweep({"drive.slip": [0.1, 0.2]}, quick=True).model_copy(update={"split": split})
    base = load_scene("rolling_wheel", quick=True)
    assert Asked(sweep, base, members_of(sweep, base)).empty_splits == empty


def test_a_grid_has_every_combination_in_order():
    vary = {"drive.slip": [0.1, 0.2], "seed": {"low": 1, "high": 100, "count": 3, "scale": "log"}}
    points = points_of(make_sweep(vary))
    assert [tuple(p.values()) for p in points][:3] == [(0.1, 1.0), (0.1, pytest.approx(10)), (0.1, 100.0)]
    assert len(points) == 6


@pytest.mark.parametrize("kind", ["latin_hypercube", "sobol"])
def test_random_designs_fill_their_spans_evenly_and_repeat_themselves(kind):
    vary = {
        "a": {"low": 2.0, "high": 4.0},
        "b": {"low": 0.01, "high": 100.0, "scale": "log"},
        "c": {"low": 1, "high": 4, "integer": True},
        "d": ["x", "y"],
    }
    points = points_of(make_sweep(vary, kind=kind, count=64, seed=3))
    assert points == points_of(make_sweep(vary, kind=kind, count=64, seed=3))
    assert points != points_of(make_sweep(vary, kind=kind, count=64, seed=4))
    a, b = (np.array([point[key] for point in points]) for key in "ab")
    # One point in each 64th of a span is what both promise, at a power of two.
    for share in ((a - 2) / 2, np.log10(b / 0.01) / 4):
        assert sorted(np.floor(64 * share).astype(int)) == list(range(64))
    for key, values in (("c", [1, 2, 3, 4]), ("d", ["x", "y"])):
        found = [point[key] for point in points]
        assert [found.count(value) for value in values] == [64 // len(values)] * len(values)
    assert all(type(point["c"]) is int for point in points)


def test_splits_have_exact_shares_and_do_not_depend_on_the_order():
    names = [f"{number:016x}" for number in range(40)]
    dealt = deal_out(names, Split(), seed=1)
    assert dealt == deal_out(reversed(names), Split(), seed=1) != deal_out(names, Split(), seed=2)
    counts = [list(dealt.values()).count(split) for split in ("train", "validation", "test")]
    assert counts == [32, 4, 4]


def test_members_share_beds_motions_and_splits_but_no_texture_across_motions():
    vary = {"drive.slip": [0.1, 0.2, 0.3], "lens.blur": [0.5, 1.0], "camera.centre_x": [0.0, 0.04]}
    split = {"train": 0.34, "validation": 0.33, "test": 0.33}
    base = load_scene("rolling_wheel", quick=True)
    members = members_of(make_sweep(vary, split=split), base).members
    assert len({m.name for m in members}) == 12
    # The region of finest grains follows from the camera: one bed holds the regions of all.
    assert len({m.bed for m in members}) == 1 and len({m.simulation for m in members}) == 3
    seeds, splits = {}, {}
    for member in members:
        seeds.setdefault(member.simulation, set()).add(member.scene.picture_seed)
        splits.setdefault(member.simulation, set()).add(member.split)
    assert all(len(found) == 1 for found in (*seeds.values(), *splits.values()))
    assert len(set().union(*seeds.values())) == 3 and len(set().union(*splits.values())) == 3
    widest = max(m.scene.bed.fine.right - m.scene.bed.fine.left for m in members)
    assert widest > changed_scene(base, {"drive.slip": 0.3}).bed.fine.right - base.bed.fine.left


def test_a_picture_seed_that_is_given_stays():
    members = members_of(make_sweep({"picture_seed": [5, 6]}), load_scene("rolling_wheel")).members
    assert [m.scene.picture_seed for m in members] == [5, 6]
    assert len({m.simulation for m in members}) == 1


def test_a_point_that_is_no_scene_is_told_and_one_that_repeats_another_is_left_out():
    found = members_of(make_sweep({"drive.slip": [0.2, 0.2, 2.0]}), load_scene("rolling_wheel", quick=True))
    assert len(found.members) == 1 and found.repeated == 1
    assert found.impossible[0].values == {"drive.slip": 2.0}
    assert "drive.slip = 2.0" in found.impossible[0].reason


def test_a_bed_key_is_equal_where_the_cached_bed_is(tiny_wheel):
    from synth.dem.bed import _bed_hash

    changes = [
        {},
        {"drive.slip": 0.35},
        {"camera.width": 200},
        {"implement.normal_load": 3.0},
        {"lens.blur": 1.0},
        {"bed.grain_diameter": 3.6e-3},
        {"seed": 9},
        {"soil.contact.friction": 0.4},
        {"soil.bulk_density": 1500.0},
    ]
    scenes = [changed_scene(tiny_wheel, change) for change in changes]
    keys = [bed_key(scene) for scene in scenes]
    cached = [_bed_hash(scene, scene.bed.settling_friction) for scene in scenes]
    for first in range(len(scenes)):
        for second in range(first):
            assert (keys[first] == keys[second]) == (cached[first] == cached[second])
    assert len(set(keys)) == 5


def test_changes_are_checked_as_a_file_is_and_rivals_give_way(tiny_wheel):
    assert changed_scene(tiny_wheel, {"soil": "fillite"}).soil.name != tiny_wheel.soil.name
    dense = changed_scene(tiny_wheel, {"bed.relative_density": 0.7})
    assert dense.bed.settling_friction is None
    with pytest.raises(SceneError, match=r"soil.contact.friction.* 'soil' is changed as a whole"):
        changed_scene(tiny_wheel, {"soil.contact.friction": 0.3, "soil": "fillite"})
    with pytest.raises(SceneError, match=r"drive.slip = 'fast'"):
        changed_scene(tiny_wheel, {"drive.slip": "fast"})
