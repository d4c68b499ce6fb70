"""The truth of a recording against fields in closed form, and against itself."""

import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from synth.truth import VARIABLES, true_motion

RADIUS, JUMP, SCALE = 30.0, 0.6, 20.0  # px; a band so wide that particles of 0.35 mm follow it to 1e-3 px
ANGLE = 0.03  # rad


@pytest.fixture(scope="module")
def band(cases):
    """Small particles in a circular shear band about the camera's centre, and its formula in the picture.

    The formula gives displacement (u, v) in px at offsets (x, y) in px from the picture's middle.
    """

    def turn(radius):
        return JUMP / RADIUS / (1 + np.exp(2 * (radius - RADIUS) / SCALE))  # (1 - tanh) / 2

    def formula(x, y):
        place = x - 1j * y  # of a plane with y up: counter-clockwise is positive
        moved = place * (np.exp(1j * turn(np.abs(place))) - 1)
        return moved.real, -moved.imag

    x, z = cases.lattice(diameter=0.35e-3, half_width=0.016, half_height=0.013)
    off = ((x - cases.centre[0]) + 1j * (z - cases.centre[1])) / cases.pixel
    moved = off * (np.exp(1j * turn(np.abs(off))) - 1) * cases.pixel
    angle = np.stack([0 * x, turn(np.abs(off))])
    recording = cases.recording([x, x + moved.real], [z, z + moved.imag], angle=angle, radius=0.175e-3)
    return recording, formula, turn


def seen_grains(recording, scene):
    """Rows and columns of the pixels that show a grain, and that grain's centre in the picture."""
    from synth.camera.cover import cover
    from synth.camera.cover_kernels import NOTHING
    from synth.truth import grains_and_motion

    grains, motion = grains_and_motion(recording, scene)
    placement = motion.start()
    covered = cover(scene, recording, grains, placement)
    seen = (covered.centres >= 0) & (covered.centres < NOTHING)
    grain = covered.tiled.grain[covered.centres[seen] & covered.tiled.index_mask]
    return *np.nonzero(seen), *covered.view.to_image(placement.x[grain], placement.z[grain])


def test_a_circular_shear_band_moves_centres_by_the_formula_and_grains_rigidly(cases, band, taichi):
    recording, formula, turn = band
    scene = cases.scene()
    truth = true_motion(recording, scene, 0, 1)
    rows, columns, x, y = seen_grains(recording, scene)
    height, width = truth.u.shape
    u, v = formula(x - (width - 1) / 2, y - (height - 1) / 2)
    # What is seen beside a grain's centre turns with the grain, by the angle that the truth tells.
    rotation = truth.rotation.values[rows, columns]
    off_x, off_y = columns - x, rows - y
    u += (np.cos(rotation) - 1) * off_x - np.sin(rotation) * off_y
    v += np.sin(rotation) * off_x + (np.cos(rotation) - 1) * off_y
    away = np.hypot(truth.u.values[rows, columns] - u, truth.v.values[rows, columns] - v)
    assert np.hypot(u, v).max() > 0.3
    assert away.max() < 1e-3
    # A grain turns by half the curl of the formula at its centre; clockwise is positive from x to y down.
    distance = np.hypot(x - (width - 1) / 2, y - (height - 1) / 2)
    step = 1e-3
    steepness = (turn(distance + step) - turn(distance - step)) / (2 * step)
    assert np.abs(rotation + turn(distance) + distance * steepness / 2).max() < 3e-4
    strain = truth.strain_rate.values[rows, columns]
    assert np.abs(strain - distance * np.abs(steepness)).max() < 5e-4


def test_carried_grains_of_a_shear_band_move_with_the_nearest_particle(cases, band, taichi):
    recording, _, _ = band
    scene = cases.scene(texture={"motion": "carried"})
    truth = true_motion(recording, scene, 0, 1)
    rows, columns, _, _ = seen_grains(recording, scene)
    particle = truth.particle_id.values[rows, columns]
    data = recording.data
    height, width = truth.u.shape
    start = data.position_x.values[0][particle] + 1j * data.position_z.values[0][particle]
    end = data.position_x.values[1][particle] + 1j * data.position_z.values[1][particle]
    place = complex(*cases.centre) + cases.pixel * (
        columns - (width - 1) / 2 - 1j * (rows - (height - 1) / 2)
    )
    moved = end + (place - start) * np.exp(1j * data.angle.values[1][particle]) - place
    u, v = moved.real / cases.pixel, -moved.imag / cases.pixel
    assert np.hypot(truth.u.values[rows, columns] - u, truth.v.values[rows, columns] - v).max() < 1e-4


def returned(forward, backward):
    """Distance from every pixel to where the motion there and back again leads, px; NaN outside."""
    height, width = forward.u.shape
    y, x = np.mgrid[:height, :width].astype(float)
    there = [y + forward.v.values, x + forward.u.values]
    back = [
        map_coordinates(field.values.astype(float), there, order=1, cval=np.nan)
        for field in (backward.v, backward.u)
    ]
    return np.hypot(there[0] + back[0] - y, there[1] + back[1] - x)


@pytest.mark.parametrize("motion", ["interpolated", "carried"])
@pytest.mark.parametrize("field", ["translation", "rotation"])
def test_forth_and_back_again_is_the_start(cases, fields, field, motion):
    moves = fields["translation"](4.3, -2.6) if field == "translation" else fields["rotation"](ANGLE)
    case = cases.case(moves, frames=3, texture={"motion": motion})
    case.recording.data["angle"][:] = (field == "rotation") * ANGLE * np.arange(3)[:, None]
    for first, second in ((0, 1), (2, 0)):
        forward = true_motion(case.recording, case.scene, first, second)
        backward = true_motion(case.recording, case.scene, second, first)
        away = returned(forward, backward)
        assert np.isfinite(away[12:-12, 12:-12]).all()
        assert np.nanmax(away) < 1e-3


def test_forth_and_back_again_in_shear_is_within_what_rigid_grains_differ(cases, fields):
    gamma = 0.02
    case = cases.case(fields["shear"](gamma))
    forward, backward = (true_motion(case.recording, case.scene, *pair) for pair in ((0, 1), (1, 0)))
    away = returned(forward, backward)[8:-8, 8:-8]
    # Half of the shear, over the distance between the centres of the grains seen there and back.
    assert np.median(away) < gamma / 2 * 2
    assert away.max() < gamma * 10


def test_two_steps_are_the_sum_of_one_and_one(cases, fields):
    case = cases.case(fields["rotation"](ANGLE), frames=4)
    one, onward, both = (true_motion(case.recording, case.scene, *pair) for pair in ((0, 1), (1, 3), (0, 3)))
    height, width = one.u.shape
    y, x = np.mgrid[:height, :width].astype(float)
    there = [y + one.v.values, x + one.u.values]
    u, v = (
        map_coordinates(field.values.astype(float), there, order=1, cval=np.nan)
        for field in (onward.u, onward.v)
    )
    assert np.nanmax(np.hypot(one.u + u - both.u, one.v + v - both.v)) < 1e-3
    for name, (dtype, _, _) in VARIABLES.items():
        assert both[name].dtype == dtype


def seen_by(case, grains, motion):
    """Light of frame 1, and the truth from frame 1 back to frame 0, of grains strewn for any camera."""
    from synth.camera.cover import cover
    from synth.camera.pair_truth import pair_truth
    from synth.camera.picture import light_on_sensor

    start = motion.start()
    placement = motion.advance(start)
    covered = cover(case.scene, case.recording, grains, placement)
    truth = pair_truth(case.scene, case.recording, covered, motion, placement, start)
    return light_on_sensor(case.scene, grains, placement, covered), truth


@pytest.mark.parametrize("field", ["rotation", "shear"])
def test_a_travelling_camera_sees_the_fixed_ones_picture_shifted_by_its_travel(cases, fields, field, taichi):
    from synth.truth import grains_and_motion

    step = 4
    travel = [0.0, step * cases.pixel]
    fixed = cases.case(fields[field](0.03), carriage=travel)
    moving = cases.case(fields[field](0.03), carriage=travel, camera={"follows": "carriage"})
    grains, motion = grains_and_motion(fixed.recording, fixed.scene)
    light_fixed, truth_fixed = seen_by(fixed, grains, motion)
    light_moving, truth_moving = seen_by(moving, grains, motion)
    left = 8  # px beside the right edge see grains that the fixed camera's texture does not have
    both = np.s_[:, step:-left], np.s_[:, : -step - left]
    assert light_fixed.std() > 0.02
    assert np.abs(light_fixed[both[0]] - light_moving[both[1]]).max() < 1e-4
    # On the same grains the travelling camera's truth has its travel more, backwards.
    for name, sideways in (("u", step), ("v", 0)):
        own = truth_moving.arrays[name][both[1]] - sideways
        assert np.abs(own - truth_fixed.arrays[name][both[0]]).max() < 1e-3
    assert truth_moving.camera["camera_u"] == pytest.approx(step)
    assert truth_fixed.camera["camera_u"] == 0
