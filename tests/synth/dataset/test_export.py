"""ParaView's files hold the recording's values."""

import base64
from xml.etree import ElementTree

import numpy as np
import pytest

from synth import load_scene, simulate
from synth.dataset.export import capsule_outlines, export_vtk
from synth.implements import Shape
from synth.scene import parse_scene

TYPES = {"Float64": "<f8", "Int64": "<i8"}


def read_arrays(path):
    """Arrays of a .vtp by name, and the numbers of its piece."""
    root = ElementTree.parse(path).getroot()
    assert root.attrib["byte_order"] == "LittleEndian" and root.attrib["header_type"] == "UInt64"
    arrays = {}
    for array in root.iter("DataArray"):
        content = base64.b64decode(array.text, validate=True)
        assert int.from_bytes(content[:8], "little") == len(content) - 8
        values = np.frombuffer(content[8:], TYPES[array.attrib["type"]])
        components = int(array.attrib["NumberOfComponents"])
        arrays[array.attrib["Name"]] = values if components == 1 else values.reshape(-1, components)
    return arrays, {name: int(count) for name, count in root.find("PolyData/Piece").attrib.items()}


@pytest.fixture(scope="module")
def exported(tiny_wheel, tiny_recording, tmp_path_factory):
    folder = tmp_path_factory.mktemp("vtk")
    export_vtk(tiny_recording, tiny_wheel, folder)
    return folder, tiny_recording.data


def test_grains_are_read_back_with_the_same_values(exported):
    folder, data = exported
    for frame in range(data.sizes["frame"]):
        arrays, counts = read_arrays(folder / f"grains-{frame:06d}.vtp")
        state = data.isel(frame=frame)
        count = data.sizes["particle"]
        assert counts == {"NumberOfPoints": count, "NumberOfVerts": count}
        np.testing.assert_array_equal(arrays["Points"][:, 0], state.position_x)
        np.testing.assert_array_equal(arrays["Points"][:, 2], state.position_z)
        np.testing.assert_array_equal(arrays["velocity"][:, 0], state.velocity_x)
        np.testing.assert_array_equal(arrays["velocity"][:, 2], state.velocity_z)
        np.testing.assert_array_equal(arrays["radius"], state.radius)
        np.testing.assert_array_equal(arrays["angle"], state.angle)
        assert not arrays["Points"][:, 1].any()
        np.testing.assert_array_equal(arrays["offsets"], np.arange(count) + 1)


def test_implement_is_where_it_was(exported, tiny_wheel):
    folder, data = exported
    arrays, counts = read_arrays(folder / "implement-000003.vtp")
    state = data.isel(frame=3)
    offset = arrays["Points"][:, [0, 2]] - (float(state.implement_x), float(state.implement_z))
    np.testing.assert_allclose(np.hypot(*offset.T), tiny_wheel.implement.radius)
    line = arrays["connectivity"]
    assert counts["NumberOfLines"] == 1 and line[0] == line[-1] and arrays["offsets"] == line.size


def test_series_lists_every_frame_with_its_time(exported):
    folder, data = exported
    for subject in ("grains", "implement"):
        entries = [entry.attrib for entry in ElementTree.parse(folder / f"{subject}.pvd").iter("DataSet")]
        assert [float(entry["timestep"]) for entry in entries] == data.time.values.tolist()
        assert all((folder / entry["file"]).is_file() for entry in entries)


def test_contacts_are_lines_with_their_forces(
    tiny_wheel_with_contacts, tiny_recording_with_contacts, tmp_path
):
    recording = tiny_recording_with_contacts
    export_vtk(recording, tiny_wheel_with_contacts, tmp_path)
    arrays, counts = read_arrays(tmp_path / "contacts-000002.vtp")
    contacts, state = recording.contacts(2), recording.data.isel(frame=2)
    count = contacts.sizes["contact"]
    assert counts == {"NumberOfPoints": 2 * count, "NumberOfLines": count}
    np.testing.assert_array_equal(arrays["Points"][::2, 0], state.position_x.values[contacts.contact_first])
    np.testing.assert_array_equal(arrays["Points"][1::2, 2], state.position_z.values[contacts.contact_second])
    np.testing.assert_array_equal(arrays["normal_force"], contacts.contact_normal_force)
    np.testing.assert_array_equal(arrays["tangential_force"], contacts.contact_tangential_force)
    magnitude = np.hypot(contacts.contact_normal_force, contacts.contact_tangential_force)
    np.testing.assert_allclose(np.linalg.norm(arrays["force"], axis=1), magnitude)
    along = arrays["Points"][1::2] - arrays["Points"][::2]
    assert ((arrays["force"] * along).sum(axis=1)[contacts.contact_normal_force.values > 0] > 0).all()
    assert len(list(ElementTree.parse(tmp_path / "contacts.pvd").iter("DataSet"))) == recording.frame_count


def test_a_solid_is_exported_by_its_edges(tiny_wheel, tmp_path):
    points = [[0.0, 0.0], [0.02, 0.0], [0.02, 0.01]]
    implement = {"kind": "outline", "width": 0.05, "points": points}
    drive = {"kind": "cutting", "speed": 0.01, "depth": 0.005, "start": 0.05, "run_in": 0.01}
    scene = parse_scene({**tiny_wheel.to_dict(), "implement": implement, "drive": drive})
    recording = simulate(scene)
    export_vtk(recording, scene, tmp_path)
    arrays, counts = read_arrays(tmp_path / "implement-000001.vtp")
    assert counts == {"NumberOfPoints": 6, "NumberOfLines": 3}
    np.testing.assert_array_equal(arrays["connectivity"].reshape(3, 2), [[0, 1], [2, 3], [4, 5]])
    at = [float(recording.data[f"implement_{axis}"][1]) for axis in "xz"]
    np.testing.assert_allclose(arrays["Points"][::2][:, [0, 2]] - at, points, atol=1e-12)


def test_outline_lies_on_the_capsules():
    shape = Shape.chain(np.array([(0.0, 0.0), (0.03, 0.01), (0.03, 0.05)]), 2e-3)
    outlines = capsule_outlines(shape)
    for capsule, outline in enumerate(outlines):
        np.testing.assert_allclose(shape.distance_to_capsules(outline)[:, capsule], 0, atol=1e-15)
    x, z = outlines[0].T
    enclosed = 0.5 * np.sum(x * np.roll(z, -1) - z * np.roll(x, -1))
    assert enclosed == pytest.approx(4e-3 * np.hypot(0.03, 0.01) + np.pi * 4e-6, rel=1e-2)


def test_a_scene_without_grains_is_refused(tmp_path):
    plate = load_scene("plate_rotation")
    with pytest.raises(ValueError, match="no grains to export"):
        export_vtk(simulate(plate), plate, tmp_path)
