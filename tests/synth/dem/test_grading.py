"""Graded beds: where the finest grains are, that layers keep clear of each other, how they settle."""

from dataclasses import replace

import numpy as np
import pytest
import tomli_w

from synth.dem.bed import settled_bed
from synth.dem.contact_law import ContactLaw
from synth.dem.grading import GradedBin, region_worked_and_seen
from synth.dem.neighbours import list_neighbours
from synth.devices import start_taichi
from synth.scene import SceneError, load_scene, parse_scene

BIN = GradedBin(0.4, 0.2, 2e-3, 0.2, 9.81, 20, coarsening=4.0, left=0.12, right=0.3, fine_bottom=0.12)


@pytest.fixture
def rolling():
    return load_scene("rolling_wheel").to_dict()


def test_the_region_is_what_is_worked_and_seen(rolling):
    bed, drive, timing, camera = (rolling[name] for name in ("bed", "drive", "timing", "camera"))
    bed |= {"width": 0.9, "depth": 0.2, "grain_diameter": 2e-3, "coarsening": 4.0}
    del bed["fine"]
    drive |= {"start": 0.3, "run_in": 0.05}
    timing |= {"frame_rate": 8.0, "frame_count": 81}
    camera |= {"width": 1000, "metres_per_pixel": 2e-4, "centre_x": 0.03}
    fine = parse_scene(rolling).bed.fine
    # Touch-down at 0.3, worked 0.6 radii of 0.114 m around and deep; margin 10 mm.
    assert fine.left == pytest.approx(0.3 - 0.0684 - 0.01)
    assert fine.bottom == pytest.approx(0.2 - 0.0684 - 0.01)
    # 50 mm to the first frame, 10 s at 8 mm/s to the last; half a picture of 0.2 m, 30 mm ahead of the axle.
    assert fine.right == pytest.approx(0.3 + 0.05 + 0.08 + 0.03 + 0.1 + 0.01)


def test_a_camera_that_stands_sees_one_place(rolling):
    del rolling["bed"]["fine"]
    rolling["camera"] |= {"follows": "bin", "centre_x": 0.45, "width": 1200, "metres_per_pixel": 2e-4}
    assert parse_scene(rolling).bed.fine.right == pytest.approx(0.45 + 0.12 + 0.01)


def test_too_little_room_up_to_a_wall_is_fine(rolling):
    del rolling["bed"]["fine"]
    rolling["bed"]["depth"] = 0.1
    assert parse_scene(rolling).bed.fine.bottom == 0.0


def test_the_resolved_scene_tells_the_region(rolling, tmp_path):
    path = tmp_path / "scene.toml"
    scene = parse_scene(rolling)
    path.write_text(scene.to_toml())
    assert load_scene(path) == scene and scene.bed.fine == region_worked_and_seen(scene)
    rolling["bed"]["fine"]["left"] += 0.01
    assert parse_scene(rolling).simulation_hash != scene.simulation_hash


@pytest.mark.parametrize(
    ("bed", "message"),
    [
        ({"coarsening": 0.5}, "bed.coarsening"),
        ({"fine": {"left": 0.3, "right": 0.2, "bottom": 0.1}}, "left < right"),
        ({"fine": {"left": 0.1, "right": 0.2, "bottom": 0.5}}, "fine: must reach into the bed"),
    ],
)
def test_bad_input(rolling, bed, message):
    rolling["bed"] |= bed
    with pytest.raises(SceneError, match=message):
        parse_scene(rolling)


def test_spheres_are_not_graded(tmp_path):
    path = tmp_path / "slab.toml"
    path.write_text(tomli_w.dumps({"base": "slab_wheel", "name": "s", "bed": {"coarsening": 2.0}}))
    with pytest.raises(SceneError, match="coarsening: for discs only"):
        load_scene(path)


@pytest.mark.parametrize(("coarsening", "count"), [(1.5, 2), (2.0, 2), (3.0, 3), (4.0, 3), (8.0, 4)])
def test_layers_grow_by_at_most_two(coarsening, count):
    diameters = replace(BIN, coarsening=coarsening).diameters
    assert diameters.size == count and diameters[0] == 2e-3
    assert diameters[-1] == pytest.approx(coarsening * 2e-3)
    assert (diameters[1:] / diameters[:-1]).max() < 2 + 1e-9


def test_dropped_grains_keep_clear_of_each_other():
    grains = BIN.drop(np.random.default_rng(0), 2000.0)
    pairs = list_neighbours(grains.position, grains.radius, 1e-4).pairs
    apart = np.hypot(*(grains.position[:, pairs[0]] - grains.position[:, pairs[1]]))
    assert pairs.shape[1] > 100 and (apart >= grains.radius[pairs].sum(axis=0)).all()
    x, z = grains.position
    within = (x > 0.12) & (x < 0.3) & (z > 1.3 * 0.12)
    assert grains.radius[within].max() <= 1.2e-3 < grains.radius[~within].min()
    assert grains.radius[(x < 0.08) | (x > 0.34)].min() >= 0.8 * 4e-3


def test_a_region_may_be_all_of_the_bin():
    whole = replace(BIN, left=0.0, right=0.4, fine_bottom=0.0)
    assert whole.drop(np.random.default_rng(0), 2000.0).radius.max() <= 1.2e-3


def test_a_graded_bed_settles_like_a_uniform_one():
    start_taichi("cpu", 1)
    region = {"left": 0.04, "right": 0.1, "fine_bottom": 0.025}
    graded = GradedBin(0.14, 0.05, 2e-3, 0.2, 9.81, 20, coarsening=2.0, **region)
    law = ContactLaw(1e6, 0.5e6, 0.3, 0.4, 0.4, 0.4, 0.2)
    grains = graded.settle(graded.drop(np.random.default_rng(1), 2000.0), law)
    x, z = grains.position
    assert graded.solid_fraction(grains) == pytest.approx(0.80, abs=0.03)
    # About as many as the areas ask for, and the finest still where they are wanted, up to the surface.
    fine = grains.radius < 1.4e-3
    assert np.pi * 1e-6 * fine.sum() == pytest.approx(0.8 * 0.06 * 0.025, rel=0.25)
    assert x[fine].min() > 0.03 and x[fine].max() < 0.11 and z[fine].min() > 0.01
    for left in np.arange(0.045, 0.095, 0.01):
        here = (x > left) & (x < left + 0.01)
        assert 0.046 < (z + grains.radius)[here].max() <= 0.05


def test_a_scene_gets_a_graded_bed(tiny_wheel):
    start_taichi("cpu", 1)
    tables = tiny_wheel.to_dict()
    tables["bed"] |= {"grain_diameter": 1.75e-3, "coarsening": 2.0}
    tables["bed"]["fine"] = {"left": 0.04, "right": 0.12, "bottom": 0.015}
    graded = settled_bed(parse_scene(tables)).grains
    assert np.unique(np.round(np.log2(graded.radius / 0.875e-3))).tolist() == [0.0, 1.0]
    assert 300 < graded.count < 1000
