import numpy as np
import pytest

from synth.dem import relative_density
from synth.dem.bed import settled_bed
from synth.dem.relative_density import SettlingRelation, settling_relation
from synth.dem.run import run_implement
from synth.devices import start_taichi
from synth.scene import SceneError, load_scene, parse_scene
from synth.soil import GrainContact

CONTACT = GrainContact(
    friction=0.5, rolling_friction=0.2, restitution=0.5, wall_friction=0.5, implement_friction=0.5
)
RELATION = SettlingRelation((0.0, 0.1, 2.0), (0.2, 0.24, 0.3))


def packing(**changes):
    measured = {
        "polydispersity": 0.2,
        "rolling_friction": CONTACT.rolling_friction,
        "restitution": CONTACT.restitution,
        "friction": [0.0, 0.1, 2.0],
        "void_ratio": [0.2, 0.24, 0.3],
    }
    return measured | changes


@pytest.fixture
def small(monkeypatch, tmp_path):
    start_taichi()
    monkeypatch.setenv("SOFTBED_CACHE", str(tmp_path))
    monkeypatch.setattr(relative_density, "SIDE", 16)
    monkeypatch.setattr(relative_density, "FRICTIONS", (0.0, 0.2, 2.0))
    monkeypatch.setattr(relative_density, "SEEDS", (1,))


def test_loosest_is_0_and_densest_is_1():
    assert (RELATION.smallest, RELATION.largest) == (0.2, 0.3)
    assert RELATION.relative_density(0.3) == 0.0
    assert RELATION.relative_density(0.2) == 1.0
    assert RELATION.relative_density(0.24) == pytest.approx(0.6)


@pytest.mark.parametrize(("density", "friction"), [(1.0, 0.0), (0.6, 0.1), (0.8, 0.05), (0.0, 2.0)])
def test_friction_that_a_relative_density_needs(density, friction):
    assert RELATION.friction_for(density) == pytest.approx(friction)


def test_more_friction_settles_looser_and_a_sample_is_made_once(small, monkeypatch):
    relation = settling_relation(CONTACT, 0.2)
    assert 0.15 < relation.smallest < relation.void_ratio[1] < relation.largest < 0.4
    monkeypatch.setattr(relative_density, "settled_sample", None)  # any new sample would fail
    assert settling_relation(CONTACT, 0.2) == relation


def test_what_the_soil_file_knows_is_used_for_such_grains_only(small, monkeypatch):
    monkeypatch.setattr(relative_density, "_void_ratio", lambda *_: pytest.fail("measured"))
    tables = load_scene("rolling_wheel").to_dict()
    tables["soil"] |= {"packing": packing(), "contact": CONTACT.model_dump()}
    known = parse_scene(tables).soil.packing
    assert settling_relation(CONTACT, 0.2, packing=known) == RELATION
    for other in ((CONTACT.model_copy(update={"rolling_friction": 0.3}), 0.2), (CONTACT, 0.1)):
        with pytest.raises(pytest.fail.Exception, match="measured"):
            settling_relation(*other, packing=known)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"friction": [0.0, 0.1]}, "as many void ratios as frictions"),
        ({"friction": [0.1, 0.2, 2.0]}, "ascend from 0"),
        ({"void_ratio": [0.2, 0.1, 0.3]}, "rise with friction"),
    ],
)
def test_a_packing_that_makes_no_sense_is_refused(changes, says):
    tables = load_scene("rolling_wheel").to_dict()
    tables["soil"]["packing"] = packing(**changes)
    with pytest.raises(SceneError, match=says):
        parse_scene(tables)


@pytest.fixture(scope="module")
def prepared(tiny_wheel):
    """The tiny wheel with beds of a relative density."""
    start_taichi()

    def scene(density):
        tables = tiny_wheel.to_dict()
        del tables["bed"]["settling_friction"]
        tables["soil"] = load_scene("rolling_wheel").to_dict()["soil"]  # which knows how its grains settle
        tables["bed"] |= {"relative_density": density, "depth": 0.06, "width": 0.2}
        return parse_scene(tables)

    return scene


def test_a_bed_gets_the_relative_density_asked_for(prepared):
    reached = {density: settled_bed(prepared(density)).relative_density for density in (0.1, 0.5, 0.9)}
    for wanted, density in reached.items():
        assert density == pytest.approx(wanted, abs=0.2)  # 500 grains; the standard bin has 700
    assert reached[0.1] < reached[0.5] < reached[0.9]


def test_a_recording_says_what_was_reached(prepared):
    scene = prepared(0.5)
    bed = settled_bed(scene)
    attributes = run_implement(scene, bed).data.attrs
    assert attributes["relative_density"] == bed.relative_density
    assert attributes["relative_density_deviation"] == pytest.approx(abs(bed.relative_density - 0.5))


@pytest.mark.parametrize("given", [{}, {"settling_friction": 0.5, "relative_density": 0.5}])
def test_a_bed_is_prepared_in_exactly_one_way(given):
    tables = load_scene("rolling_wheel").to_dict()
    del tables["bed"]["relative_density"]
    tables["bed"] |= given
    with pytest.raises(SceneError, match="exactly one of settling_friction and relative_density"):
        parse_scene(tables)


def test_one_way_takes_the_place_of_the_bases_other(tmp_path):
    path = tmp_path / "x.toml"
    path.write_text('base = "rolling_wheel"\n[bed]\nsettling_friction = 0.4\n')
    bed = load_scene(path).bed
    assert (bed.relative_density, bed.settling_friction) == (None, 0.4)


def test_beds_of_other_densities_are_other_beds(prepared):
    one, other = (settled_bed(prepared(density)).grains for density in (0.1, 0.9))
    assert one.count != other.count or not np.array_equal(one.position, other.position)
