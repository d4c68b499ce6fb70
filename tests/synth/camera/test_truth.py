import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt

from synth.truth import true_motion

TURN = 0.03  # rad, counter-clockwise
WHEEL = 8e-3  # m


def rotated(angle, offsets):
    """Displacement of a counter-clockwise rotation about the picture's centre, in the picture (y down)."""
    x, y = offsets
    cosine, sine = np.cos(angle), np.sin(angle)
    return (cosine - 1) * x + sine * y, -sine * x + (cosine - 1) * y


def off(truth, u, v):
    """Largest distance from an expected motion, px."""
    return float(np.hypot(truth.u - u, truth.v - v).max())


def test_a_translation_is_exact_and_up_is_minus_v(cases, fields):
    case = cases.case(fields["translation"](2.5, 1.25))
    truth = true_motion(case.recording, case.scene, 0, 1)
    assert off(truth, 2.5, -1.25) < 1e-4
    assert (truth.camera_u, truth.camera_v) == (0, 0)


def test_what_leaves_the_picture_could_not_be_measured(cases, fields):
    case = cases.case(fields["translation"](2.5, 1.25))
    truth = true_motion(case.recording, case.scene, 0, 1)
    height, width = truth.valid.shape
    stays = np.zeros((height, width), bool)
    stays[2:, : width - 3] = True  # y - 1.25 >= 0 and x + 2.5 <= width - 1
    np.testing.assert_array_equal(truth.valid, stays)
    assert np.isfinite(truth.u).all()  # known all the same


def test_a_plate_rotates_every_pixel_exactly(cases, offsets):
    case = cases.plate([0.0, TURN])
    truth = true_motion(case.recording, case.scene, 0, 1)
    assert truth.valid.values[5:-5, 5:-5].all()
    assert truth.soil.all()
    assert off(truth, *rotated(TURN, offsets)) < 1e-5
    assert truth.rotation.values == pytest.approx(-TURN)  # counter-clockwise is negative from x to y down
    assert np.isinf(truth.distance_to_implement).all()
    assert np.isinf(truth.distance_to_discontinuity).all()
    assert np.isnan(truth.discontinuity_jump).all()


@pytest.mark.parametrize("motion", ["interpolated", "carried"])
def test_a_rotation_of_the_particles_is_exact(cases, fields, offsets, motion):
    case = cases.case(fields["rotation"](TURN), texture={"motion": motion})
    case.recording.data["angle"][1] = TURN
    truth = true_motion(case.recording, case.scene, 0, 1)
    assert off(truth, *rotated(TURN, offsets)) < 1e-4
    assert truth.rotation.values == pytest.approx(-TURN)
    assert truth.strain_rate.max() < 1e-5


def test_simple_shear_moves_centres_by_the_formula_and_grains_rigidly(cases, fields, offsets, taichi):
    from synth.camera.cover import cover
    from synth.camera.cover_kernels import NOTHING
    from synth.truth import grains_and_motion

    gamma = 0.04
    case = cases.case(fields["shear"](gamma))
    truth = true_motion(case.recording, case.scene, 0, 1)
    grains, motion = grains_and_motion(case.recording, case.scene)
    covered = cover(case.scene, case.recording, grains, motion.start())
    seen = (covered.centres >= 0) & (covered.centres < NOTHING)
    grain = covered.tiled.grain[covered.centres[seen] & covered.tiled.index_mask]
    rows, columns = np.nonzero(seen)
    height = len(seen)
    grain_x, grain_y = covered.view.to_image(grains.x[grain], grains.z[grain])
    off_x, off_y = columns - grain_x, rows - grain_y
    turn = np.arctan2(gamma, 2.0)  # clockwise, so from x towards y
    u = -gamma * (grain_y - (height - 1) / 2)
    u += (np.cos(turn) - 1) * off_x - np.sin(turn) * off_y
    v = np.sin(turn) * off_x + (np.cos(turn) - 1) * off_y
    assert seen.mean() > 0.8
    assert np.hypot(truth.u.values[seen] - u, truth.v.values[seen] - v).max() < 1e-4
    # Grains turn by half of the shear, so a pixel is off the continuum by half of it over the grain's radius.
    bound = gamma / 2 * grains.diameter.max() / 2 / cases.pixel + gamma * 3
    assert off(truth, -gamma * offsets[1], 0) < bound
    assert truth.strain_rate.values == pytest.approx(gamma, rel=1e-3)
    assert truth.rotation.values == pytest.approx(turn)


def test_a_travelling_camera_sees_the_same_less_its_own_motion(cases, fields):
    travel = [0.0, 2.5 * cases.pixel]
    fixed = cases.case(fields["rotation"](TURN), carriage=travel)
    moving = cases.case(fields["rotation"](TURN), carriage=travel, camera={"follows": "carriage"})
    seen_fixed = true_motion(fixed.recording, fixed.scene, 0, 1)
    seen_moving = true_motion(moving.recording, moving.scene, 0, 1)
    assert off(seen_moving, seen_fixed.u - 2.5, seen_fixed.v) < 1e-4


def test_static_soil_moves_backwards_past_a_travelling_camera(cases, fields):
    carriage = [0.0, 3 * cases.pixel]
    case = cases.case(fields["rest"], carriage=carriage, camera={"follows": "carriage"})
    truth = true_motion(case.recording, case.scene, 0, 1)
    assert off(truth, -3.0, 0.0) < 1e-4
    assert (truth.camera_u, truth.camera_v) == pytest.approx((-3.0, 0.0))


def test_forward_then_backward_returns_to_the_start(cases, fields, offsets):
    case = cases.case(fields["translation"](4, -3))
    forward = true_motion(case.recording, case.scene, 0, 1)
    backward = true_motion(case.recording, case.scene, 1, 0)
    assert off(forward, 4, 3) < 1e-4
    assert off(backward, -4, -3) < 1e-4
    turned = cases.case(fields["rotation"](TURN))
    backward = true_motion(turned.recording, turned.scene, 1, 0)
    assert off(backward, *rotated(-TURN, offsets)) < 1e-4


def test_any_two_frames_and_rates_are_a_frame(cases, fields, offsets):
    case = cases.case(fields["rotation"](TURN), frames=4)
    truth = true_motion(case.recording, case.scene, 1, 3)
    assert off(truth, *rotated(2 * TURN, offsets)) < 1e-3
    assert truth.rotation.values == pytest.approx(-TURN, rel=1e-5)
    assert int(truth.first_frame) == 1
    assert int(truth.second_frame) == 3
    assert float(truth.time) == pytest.approx(1 / 8)


@pytest.mark.parametrize(("first", "second"), [(0, 2), (-1, 0), (1, 1)])
def test_frames_that_make_no_pair_are_refused(cases, fields, first, second):
    case = cases.case(fields["rest"])
    with pytest.raises(ValueError, match=r"^(frame|second) = "):
        true_motion(case.recording, case.scene, first, second)


@pytest.fixture(scope="module")
def wheel(cases, fields):
    """A wheel in the picture's middle that turns clockwise while soil rests, seen by a fixed camera."""
    scene = cases.scene()
    scene = scene.model_copy(update={"implement": scene.implement.model_copy(update={"radius": WHEEL})})
    axle = [cases.centre[0], cases.centre[0] + 3 * cases.pixel], cases.centre[1]
    still = cases.case(fields["rest"], implement=axle, turn=[0.0, -0.2])
    return true_motion(still.recording, scene, 0, 1)


def test_the_implement_has_its_own_rigid_motion(wheel, offsets):
    u, v = rotated(-0.2, offsets)
    on = wheel.implement.values
    assert np.array_equal(on, np.hypot(*offsets) <= 40)
    assert np.hypot(wheel.u.values - u - 3, wheel.v.values - v)[on].max() < 1e-5
    assert wheel.v.values[48, 100] > 0  # the right side of a wheel that rolls to the right goes down
    assert wheel.valid.values[on].all()
    assert not wheel.soil.values[on].any()
    assert (wheel.particle_id.values[on] == -1).all()


def test_distances_to_the_implement_are_exact(wheel, offsets):
    expected = np.maximum(np.hypot(*offsets) - 40, 0)
    assert np.abs(wheel.distance_to_implement.values - expected).max() < 1e-4


def test_soil_and_implement_have_a_discontinuity_between_them(wheel):
    on = wheel.implement.values
    beside = np.zeros_like(on)
    across, down = on[:, 1:] != on[:, :-1], on[1:] != on[:-1]
    beside[:, 1:] |= across
    beside[:, :-1] |= across
    beside[1:] |= down
    beside[:-1] |= down
    assert wheel.distance_to_discontinuity.values == pytest.approx(distance_transform_edt(~beside) + 0.5)
    assert wheel.discontinuity_jump.values[48, 127] == pytest.approx(np.hypot(3.0, 8.0), abs=0.7)


def test_pixels_of_the_rim_are_mixed_and_none_else(wheel, offsets):
    away = np.abs(np.hypot(*offsets) - 40)
    mixed = wheel.mixed.values
    # Inside the wheel, a turn of 0.2 moves the corners of a pixel's samples further apart than the limit.
    outside = np.hypot(*offsets) > 40
    assert not mixed[outside & (away > 0.75)].any()
    assert mixed[outside & (away < 0.3)].all()


def test_air_has_no_motion(cases):
    x, z = cases.lattice()
    below = z < cases.centre[1]
    recording = cases.recording([x[below]] * 2, [z[below]] * 2)
    truth = true_motion(recording, cases.scene(), 0, 1)
    air = np.s_[:30]
    assert not truth.soil[air].any()
    assert not truth.valid[air].any()
    assert np.isnan(truth.u[air]).all()
    assert (truth.particle_id[air] == -1).all()
    ground = np.s_[60:]
    assert truth.soil[ground].all()
    assert truth.valid[ground].all()


def test_particle_ids_name_the_nearest_particle(cases, fields, offsets):
    case = cases.case(fields["rest"])
    truth = true_motion(case.recording, case.scene, 0, 1)
    x = cases.centre[0] + offsets[0] * cases.pixel
    z = cases.centre[1] - offsets[1] * cases.pixel
    all_x, all_z = case.recording.data["position_x"].values[0], case.recording.data["position_z"].values[0]
    square = (x[..., None] - all_x) ** 2 + (z[..., None] - all_z) ** 2
    # A grain's centre, not the pixel's, decides: pixels near the border of two particles may differ.
    assert np.mean(truth.particle_id.values == square.argmin(axis=-1)) > 0.85


def test_a_split_is_found_where_it_is(taichi):
    from synth.camera.discontinuities import discontinuities

    u = np.zeros((40, 60), np.float32)
    u[:, 25:] = 2.0
    found = discontinuities(u, np.zeros_like(u), np.zeros(u.shape, bool))
    expected = np.abs(np.arange(60) - 24.5)
    assert np.array_equal(found["distance_to_discontinuity"], np.tile(expected, (40, 1)))
    assert (found["discontinuity_jump"] == 2.0).all()


def test_distances_agree_with_an_independent_transform(taichi):
    from synth.camera.discontinuities import discontinuities

    generator = np.random.default_rng(8)
    u = np.where(generator.random((70, 90)) < 0.003, 3.0, 0.0).astype(np.float32)
    found = discontinuities(u, 0 * u, np.zeros(u.shape, bool))
    marked = np.zeros(u.shape, bool)
    marked[:, 1:] |= u[:, 1:] != u[:, :-1]
    marked[:, :-1] |= u[:, 1:] != u[:, :-1]
    marked[1:] |= u[1:] != u[:-1]
    marked[:-1] |= u[1:] != u[:-1]
    assert found["distance_to_discontinuity"] == pytest.approx(distance_transform_edt(~marked) + 0.5)
