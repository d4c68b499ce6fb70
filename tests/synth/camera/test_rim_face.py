"""A wheel with an elastic rim is drawn as it is deformed, and its truth follows its side."""

import numpy as np
import pytest

from synth import Recording
from synth.camera import rim_face
from synth.camera.implement_face import face_of
from synth.camera.pair_truth import add_implement
from synth.camera.view import View
from synth.scene import parse_scene

RADIUS, FLAT = 0.01, 0.003
WIDTH, HEIGHT, PIXEL = 160, 150, 2e-4


@pytest.fixture
def scene(cases):
    tables = cases.scene().to_dict()
    tables["implement"] |= {
        "kind": "compliant_wheel",
        "radius": RADIUS,
        "deflection": FLAT,
        "node_count": 240,
        "rim_thickness": 4e-4,
        "rim_mass": 0.5,
        "bending_stiffness": 1e-4,
        "hoop_stiffness": 1e3,
        "tangential_stiffness_ratio": 0.5,
        "damping_ratio": 1.0,
    }
    return parse_scene(tables)


def nodes_of(scene, *, turn=0.0, flat=0.0):
    """Nodes from the axle, turned, and cut `flat` above the lowest point."""
    half = scene.implement.rim_thickness / 2
    angle = 2 * np.pi * np.arange(240) / 240 + turn
    nodes = (RADIUS - half) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    nodes[:, 1] = np.maximum(nodes[:, 1], -(RADIUS - half - flat))
    return nodes


def recording_of(cases, scene, rims, turns):
    case = cases.case(lambda x, z, frame: (x, z), implement=cases.centre, turn=turns, frames=len(rims))
    nodes = np.array(rims) + cases.centre
    rim = {f"rim_{axis}": (("frame", "node"), nodes[:, :, i]) for i, axis in enumerate("xz")}
    return Recording(case.recording.data.assign(rim))


def test_a_flattened_rim_is_drawn_flat_below_and_round_elsewhere(taichi, cases, scene):
    recording = recording_of(cases, scene, [nodes_of(scene, turn=0.3, flat=FLAT)], [0.3])
    view = View(WIDTH, HEIGHT, PIXEL, *cases.centre)
    inside = face_of(scene, recording, 0, view).distance() == 0
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    world_x, world_z = view.to_world(x, y)
    off_x, off_z = world_x - cases.centre[0], world_z - cases.centre[1]
    expected = (np.hypot(off_x, off_z) < RADIUS) & (off_z > -(RADIUS - FLAT))
    near = np.abs(np.hypot(off_x, off_z) - RADIUS) < 0.6 * PIXEL
    near |= np.abs(off_z + RADIUS - FLAT) < 0.6 * PIXEL
    np.testing.assert_array_equal(inside[~near], expected[~near])


@pytest.mark.parametrize("turn", [0.0, 2.5])
def test_samples_are_covered_as_the_capsules_say(taichi, cases, scene, turn):
    from synth.camera import cover_kernels as kernels

    recording = recording_of(cases, scene, [nodes_of(scene, turn=turn, flat=FLAT)], [turn])
    face = face_of(scene, recording, 0, View(WIDTH, HEIGHT, PIXEL, *cases.centre))
    samples = np.zeros((HEIGHT, WIDTH, 3, 3), np.int32)
    centres = np.zeros((HEIGHT, WIDTH), np.int32)
    numbers = kernels.projection.numbers(face.view.numbers)
    kernels.cover_by_implement(face.x, face.y, face.parts, numbers, 3, 0, face.box(0), samples, centres)
    covered = samples[:, :, 1, 1] == kernels.IMPLEMENT  # the middle one of a pixel is its centre
    np.testing.assert_array_equal(covered, face.distance() == 0)
    np.testing.assert_array_equal(covered, centres == kernels.IMPLEMENT)
    assert 0.2 < covered.mean() < 0.8


def test_points_of_the_side_are_found_again(taichi, cases, scene):
    recording = recording_of(cases, scene, [nodes_of(scene, flat=FLAT)], [0.0])
    face = face_of(scene, recording, 0, View(WIDTH, HEIGHT, PIXEL, *cases.centre))
    angle, radius = np.random.default_rng(1).uniform([[0.0], [0.0]], [[2 * np.pi], [32.0]], (2, 500))
    points = radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    points = points[points[:, 1] < (RADIUS - FLAT) / PIXEL]
    material = rim_face.material_points(face.rim, points)
    np.testing.assert_allclose(rim_face.deformed_points(face.rim, material), points, atol=0.01)
    # What is flattened was lower, by the whole flattening at the lowest point; y is down.
    bottom = np.array([[0.0, (RADIUS - FLAT) / PIXEL]])
    np.testing.assert_allclose(rim_face.material_points(face.rim, bottom), [[0.0, RADIUS / PIXEL]], atol=0.05)


@pytest.mark.parametrize("turn", [0.0, 0.4])
def test_truth_of_the_side_follows_the_rim(taichi, cases, scene, turn):
    """The rim flattens while it turns: its lowest pixels rise, its hub only turns."""
    rims = [nodes_of(scene), nodes_of(scene, turn=turn, flat=FLAT)]
    recording = recording_of(cases, scene, rims, [0.0, turn])
    view = View(WIDTH, HEIGHT, PIXEL, *cases.centre)
    face, following = (face_of(scene, recording, frame, view) for frame in (0, 1))
    shape = HEIGHT, WIDTH
    arrays = {
        name: np.zeros(shape, np.float32)
        for name in ("u", "v", "rotation", "strain_rate", "distance_to_implement")
    }
    arrays["valid"] = np.zeros(shape, bool)
    arrays["implement"] = face.distance() == 0
    add_implement(arrays, face, following)
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    off_x, off_y = x - face.x, y - face.y
    end_x, end_y = off_x + arrays["u"], off_y + arrays["v"]
    hub = np.hypot(off_x, off_y) < 0.2 * RADIUS / PIXEL
    np.testing.assert_allclose(np.hypot(end_x, end_y)[hub], np.hypot(off_x, off_y)[hub], atol=1e-3)
    rim = arrays["implement"] & (np.hypot(off_x, off_y) > 0.97 * RADIUS / PIXEL)
    assert end_y[rim].max() < (RADIUS - FLAT) / PIXEL + 0.1
    assert end_y[rim].max() > (RADIUS - FLAT) / PIXEL - 2
    # Counter-clockwise seen in the world is from right to up: y falls on the right.
    right = rim & (off_y > -3) & (off_y < 3) & (off_x > 0)
    expected = -np.sin(turn) * RADIUS / PIXEL
    assert arrays["v"][right].mean() == pytest.approx(expected, abs=2)
