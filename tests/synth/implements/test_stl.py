"""An STL cut by the glass is the implement it was made from."""

import numpy as np
import pytest
import trimesh

from synth import simulate
from synth.devices import start_taichi
from synth.implements import Shape
from synth.implements.outline import OutlineError, check_outline, signed_area
from synth.implements.stl import Stl, StlError
from synth.scene import SceneError, load_scene, parse_scene

SECTIONS = 128
"""Chords of the cylinder."""


def cut(folder, mesh, **options):
    mesh.export(folder / "body.stl")
    table = {"kind": "stl", "file": "body.stl", "scale": 1e-3, "width": 0.05, **options}
    return Stl.model_validate(table).outlined(folder)


def cylinder(radius, height):
    """In mm, its axis along y."""
    mesh = trimesh.creation.cylinder(radius=radius, height=height, sections=SECTIONS)
    return mesh.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))


def corner_box():
    """A box from the origin to (40, 20, 10) mm."""
    return trimesh.creation.box(bounds=[[0, 0, 0], [40, 20, 10]])


@pytest.mark.parametrize(
    ("axes", "corners"),
    [
        ({"along": "+x", "up": "+z", "slice": 0.01}, (0.0, 0.04, 0.0, 0.01)),
        ({"along": "-x", "up": "+z", "slice": 0.01}, (-0.04, 0.0, 0.0, 0.01)),
        ({"along": "+y", "up": "-x", "slice": 0.005}, (0.0, 0.02, -0.04, 0.0)),
        ({"along": "+z", "up": "+y", "slice": 0.03}, (0.0, 0.01, 0.0, 0.02)),
        ({"slice": 0.01, "reference": [0.04, 0.01]}, (-0.04, 0.0, -0.01, 0.0)),
    ],
)
def test_axes_slice_and_reference_are_what_they_say(tmp_path, axes, corners):
    points = np.array(cut(tmp_path, corner_box(), **axes)["points"])
    assert len(points) == 4
    (left, bottom), (right, top) = points.min(axis=0), points.max(axis=0)
    np.testing.assert_allclose((left, right, bottom, top), corners, atol=1e-9)
    assert signed_area(points) > 0


def test_a_cylinder_is_a_wheel_within_the_chords(tmp_path):
    table = cut(tmp_path, cylinder(114, 57), normal_load=30.0, moving_mass=0.3, tolerance=0.0)
    assert table["kind"] == "outline_wheel" and table["radius"] == pytest.approx(0.114, rel=1e-6)
    assert len(table["points"]) == SECTIONS
    scene = parse_scene({**load_scene("rolling_wheel").to_dict(), "implement": table})
    shape, rim = scene.implement.shape, load_scene("rolling_wheel").implement.shape
    rng = np.random.default_rng(0)
    angle, away = rng.uniform(0, 2 * np.pi, 500), rng.uniform(0.114, 0.2, 500)
    points = away[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    chord = 0.114 * (1 - np.cos(np.pi / SECTIONS))
    difference = shape.distance_to_capsules(points).min(axis=1) - rim.distance_to_capsules(points)[:, 0]
    assert difference.min() > -1e-8 and difference.max() < 1.01 * chord
    assert not shape.encloses(points).any() and shape.encloses(0.99 * points * 0.114 / away[:, None]).all()


def test_fewer_corners_are_off_by_the_tolerance_at_most(tmp_path):
    fine = np.array(cut(tmp_path, cylinder(114, 57), tolerance=0.0)["points"])
    coarse = cut(tmp_path, cylinder(114, 57), tolerance=1e-3)["points"]
    assert len(coarse) < len(fine) / 2
    assert Shape.outline(coarse).distance_to_capsules(fine).min(axis=1).max() < 1.001e-3


def test_a_ring_is_solid(tmp_path):
    ring = trimesh.creation.annulus(r_min=80, r_max=114, height=50, sections=64)
    points = np.array(cut(tmp_path, ring, along="+x", up="+y", slice=0.01)["points"])
    assert np.hypot(*points.T).min() > 0.113


def test_errors_name_what_is_wrong(tmp_path):
    two = trimesh.util.concatenate([corner_box(), corner_box().apply_translation([100, 0, 0])])
    fork = trimesh.creation.torus(major_radius=50, minor_radius=10)
    half_open = corner_box()
    half_open.update_faces(np.arange(len(half_open.faces)) > 0)
    for mesh, options, words in (
        (two, {}, "file = 'body.stl': holds 2 bodies"),
        (half_open, {}, "file = 'body.stl': the body is not watertight"),
        (corner_box(), {"slice": 0.03}, "slice = 0.03: no section there: the body is between 0 and 0.02 m"),
        (fork, {"along": "+x", "up": "+z"}, "slice = 0: the section there has 2 separate parts"),
        (corner_box(), {"along": "+x", "up": "-x"}, "up = '-x': along = '\\+x' is the same axis"),
        (corner_box(), {"slice": 0.01, "normal_load": 3.0}, "moving_mass: missing"),
    ):
        with pytest.raises(StlError, match=words):
            cut(tmp_path, mesh, **options)
    (tmp_path / "text.stl").write_text("no triangles here")
    for file, words in (("nowhere.stl", "no such file"), ("text.stl", "not an STL file|holds no triangle")):
        with pytest.raises(StlError, match=words):
            cut(tmp_path, corner_box(), file=file)


def test_outlines_that_enclose_nothing_or_cross_are_refused():
    check_outline(np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]]))
    with pytest.raises(OutlineError, match="edge 0 crosses edge 2"):
        check_outline(np.array([[0.0, 0], [1, 1], [1, 0], [0, 0.9]]))
    with pytest.raises(OutlineError, match="enclose no area"):
        check_outline(np.array([[0.0, 0], [1, 0], [2, 0]]))


def scene_file(folder, implement):
    lines = "\n".join(f"{key} = {value!r}" for key, value in implement.items())
    path = folder / "scene.toml"
    drive = 'kind = "cutting"\nspeed = 0.01\ndepth = 0.02\nstart = 0.15\nrun_in = 0.1\n'
    path.write_text(f'base = "rolling_wheel"\nname = "box"\n[drive]\n{drive}[implement]\n{lines}\n')
    return path


def test_a_scene_finds_the_file_beside_it_and_depends_on_its_content(tmp_path):
    corner_box().export(tmp_path / "box.stl")
    path = scene_file(
        tmp_path, {"kind": "stl", "file": "box.stl", "scale": 1e-3, "slice": 0.01, "width": 0.05}
    )
    scene = load_scene(path)
    assert scene.implement.kind == "outline" and "box.stl" in scene.implement.source
    (tmp_path / "resolved.toml").write_text(scene.to_toml())
    corner_box().apply_scale([1, 1, 1.1]).export(tmp_path / "box.stl")
    assert load_scene(path).simulation_hash != scene.simulation_hash
    (tmp_path / "box.stl").unlink()
    assert load_scene(tmp_path / "resolved.toml") == scene
    with pytest.raises(SceneError, match=r"scene\.toml: .*implement\.file = 'box\.stl': no such file"):
        load_scene(path)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"scale": -1.0}, r"implement\.scale = -1\.0: .*greater than 0"),
        ({"cut": 1}, r"implement\.cut = 1: unk"),
    ],
)
def test_a_scene_names_the_key(tmp_path, change, words):
    corner_box().export(tmp_path / "box.stl")
    table = {"kind": "stl", "file": "box.stl", "scale": 1e-3, "slice": 0.01, "width": 0.05, **change}
    with pytest.raises(SceneError, match=words):
        load_scene(scene_file(tmp_path, table))


def test_a_tool_cannot_roll(tmp_path, tiny_wheel):
    table = cut(tmp_path, corner_box(), slice=0.01)
    with pytest.raises(SceneError, match=r"drive\.kind = 'rolling' needs a wheel, .*'outline'"):
        parse_scene({**tiny_wheel.to_dict(), "implement": table})


def steady(recording):
    after = recording.data.where(recording.data.sample_time > 0, drop=True)
    return {name: float(after[name].mean()) for name in ("sinkage", "force_x", "force_z", "torque")}


def test_a_cylinders_stl_carries_the_load_of_the_wheel(tmp_path, tiny_wheel, tiny_recording):
    """The same bed soon scatters grains elsewhere: what is the same is what holds the wheel up."""
    wheel = tiny_wheel.implement
    load = {"normal_load": wheel.normal_load, "moving_mass": wheel.moving_mass, "width": wheel.width}
    table = cut(tmp_path, cylinder(1000 * wheel.radius, 30), **load, tolerance=0.0)
    rolled = simulate(parse_scene({**tiny_wheel.to_dict(), "implement": table}))
    forces, rigid = steady(rolled), steady(tiny_recording)
    assert forces["sinkage"] == pytest.approx(rigid["sinkage"], abs=tiny_wheel.bed.grain_diameter)
    assert forces["force_z"] == pytest.approx(wheel.normal_load, rel=0.1)
    assert forces["torque"] > 0
    np.testing.assert_allclose(rolled.data.slip, tiny_wheel.drive.slip, rtol=1e-6)


def test_a_grain_rests_on_an_edge_and_on_a_corner(tmp_path):
    """On an edge at half the edge's angle, a grain lies where the chord is, and pushes with its weight."""
    start_taichi()
    from synth.dem.contact_law import ContactLaw, damping_ratio_of, largest_time_step
    from synth.dem.grains import Grains
    from synth.dem.solver import Solver
    from synth.dem.tool import Tool

    points = np.array(cut(tmp_path, cylinder(20, 30), tolerance=0.0)["points"])
    shape, radius, weight = Shape.outline(points), 1e-3, np.pi * 1e-6 * 2000 * 9.81
    law = ContactLaw(1e6, 5e5, damping_ratio_of(0.2), 0.5, 0.5, 0.5, 0.0)
    for turn, height in ((np.pi / SECTIONS, 0.02 * np.cos(np.pi / SECTIONS)), (0.0, 0.02)):
        angle = np.pi / 2 - np.arctan2(*points[0, ::-1]) + turn
        grains = Grains.at_rest(np.array([[0.05], [0.05 + height + radius]]), np.array([radius]), 2000.0)
        tool = Tool(shape, x=0.05, z=0.05, angle=angle)
        step = largest_time_step(grains.mass, 1e6, 50)
        solver = Solver(grains, law, 0.1, step, drag=2000.0, tool=tool)
        solver.advance(4000)
        solver.take_tool_impulse()
        solver.advance(400)
        impulse = solver.take_tool_impulse()
        top = float(solver.read_grains().position[1, 0]) - 0.05 - radius
        assert top == pytest.approx(height - weight / 1e6, abs=1e-8)
        assert impulse.z == pytest.approx(-weight * 400 * step, rel=1e-3)


def test_a_box_is_pushed_back_by_the_soil_it_cuts(tmp_path, tiny_wheel):
    table = cut(tmp_path, corner_box(), slice=0.01, reference=[0.04, 0.0], width=0.057)
    drive = {"kind": "cutting", "speed": 0.01, "depth": 0.008, "start": 0.07, "run_in": 0.03}
    recording = simulate(parse_scene({**tiny_wheel.to_dict(), "implement": table, "drive": drive}))
    forces = steady(recording)
    assert forces["force_x"] < -abs(forces["force_z"])
    assert forces["sinkage"] == pytest.approx(0.008, abs=1e-3)
    x, z = (recording.data[name].values[-1] for name in ("position_x", "position_z"))
    offset = np.stack([x, z], axis=1) - [float(recording.data[f"implement_{a}"][-1]) for a in "xz"]
    shape = parse_scene({**tiny_wheel.to_dict(), "implement": table, "drive": drive}).implement.shape
    assert not shape.encloses(offset).any()
    ahead = (offset[:, 0] > 0) & (offset[:, 0] < 0.02)
    assert recording.data.velocity_x.values[-1][ahead].mean() > 0
