import numpy as np
import pytest
from pydantic import TypeAdapter

from synth.analytic.motion import Motion

MOTIONS = {
    "translation": {"kind": "translation", "u": 2.5, "v": -1.25},
    "simple_shear": {"kind": "simple_shear", "shear": 0.04, "centre_y": 10.0},
    "rotation": {"kind": "rotation", "angle": 0.03, "centre_x": 20.0, "centre_y": -10.0},
    "shear_band": {"kind": "shear_band", "radius": 60.0, "jump": 8.0, "scale": 2.0, "centre_x": 5.0},
    "sinusoidal_strain": {
        "kind": "sinusoidal_strain",
        "amplitude": 0.5,
        "shortest": 20.0,
        "longest": 90.0,
        "span": 240.0,
    },
}


def motion_of(name):
    return TypeAdapter(Motion).validate_python(MOTIONS[name])


@pytest.fixture(scope="module")
def points():
    generator = np.random.default_rng(4)
    return generator.uniform(-120, 120, 4000), generator.uniform(-80, 80, 4000)


def expected(name, x, y):
    """Displacement by the textbook's formula, written apart from the program."""
    if name == "translation":
        return 2.5 + 0 * x, -1.25 + 0 * y
    if name == "simple_shear":
        return 0.04 * (y - 10), 0 * y
    if name == "sinusoidal_strain":
        period = 20.0 * np.exp(np.log(90 / 20) * (x + 120) / 240)
        return 0 * x, 0.5 * np.cos(2 * np.pi * y / period)
    # A turn by a in complex numbers of a plane with y up, where counter-clockwise is positive.
    centre = 20.0 + 10.0j if name == "rotation" else 5.0 + 0j
    place = x - 1j * y - centre
    angle = 0.03 if name == "rotation" else 8.0 / 60 / (1 + np.exp(abs(place) - 60))  # (1 - tanh(t / 2)) / 2
    moved = place * np.exp(1j * angle) - place
    return moved.real, -moved.imag


@pytest.mark.parametrize("name", MOTIONS)
def test_displacement_is_the_textbooks(points, name):
    u, v = motion_of(name).displacement(*points, 0, 1)
    expected_u, expected_v = expected(name, *points)
    assert np.hypot(u - expected_u, v - expected_v).max() < 1e-9


def test_signs_as_seen():
    at = np.array([50.0]), np.array([0.0])  # to the right of the middle
    u, v = motion_of("rotation").model_copy(update={"centre_x": 0.0, "centre_y": 0.0}).displacement(*at, 0, 1)
    assert u < 0 and v < -1.4  # counter-clockwise as seen: the right side goes up
    assert motion_of("simple_shear").displacement(np.zeros(1), np.array([60.0]), 0, 1)[0] == 2.0


def test_a_shear_band_turns_inside_and_rests_outside():
    band = motion_of("shear_band")
    x = 5.0 + np.array([30.0, 60.0, 90.0])
    u, v = band.displacement(x, 0 * x, 0, 1)
    assert np.hypot(u, v) == pytest.approx([30 * 8 / 60, 4.0, 0.0], rel=2e-3, abs=1e-9)
    off = np.hypot(x + u - 5.0, v)
    assert off == pytest.approx(x - 5.0)  # nothing leaves its circle


@pytest.mark.parametrize("name", MOTIONS)
@pytest.mark.parametrize("frame", [1, 2, -1])
def test_place_and_origin_are_inverses(points, name, frame):
    motion = motion_of(name)
    there = motion.place(*points, frame)
    assert np.abs(np.subtract(motion.origin(*there, frame), points)).max() < 1e-10
    came_from = motion.origin(*points, frame)
    assert np.abs(np.subtract(motion.place(*came_from, frame), points)).max() < 1e-10


@pytest.mark.parametrize("name", MOTIONS)
def test_motions_follow_each_other(points, name):
    motion = motion_of(name)
    u, v = motion.displacement(*points, 0, 1)
    x, y = points[0] + u, points[1] + v
    onward = motion.displacement(x, y, 1, 3)
    whole = motion.displacement(*points, 0, 3)
    assert np.abs(np.subtract(whole, np.add((u, v), onward))).max() < 1e-9
    back = motion.displacement(x, y, 1, 0)
    assert np.abs(np.add((u, v), back)).max() < 1e-9


def test_gradients_are_the_textbooks(points):
    turn = motion_of("rotation").gradient(*points, 0, 1)
    cosine, sine = np.cos(0.03), np.sin(0.03)
    assert np.abs(turn - [[cosine - 1, sine], [-sine, cosine - 1]]).max() < 1e-8
    shear = motion_of("simple_shear").gradient(*points, 0, 2)
    assert np.abs(shear - [[0, 0.08], [0, 0]]).max() < 1e-8
    wave = motion_of("sinusoidal_strain").gradient(*points, 0, 1)
    number = 2 * np.pi / (20.0 * np.exp(np.log(90 / 20) * (points[0] + 120) / 240))
    assert np.abs(wave[:, 1, 1] + 0.5 * number * np.sin(number * points[1])).max() < 1e-6


def test_a_strain_that_would_fold_is_told():
    wave = motion_of("sinusoidal_strain")
    assert [wave.folds_within(frame) for frame in (1, 5, 6)] == [False, False, True]
