import numpy as np
import pytest

from validation.scoring.strata import STRATA, camera_displacement, find_strata, gradient_norm

SHAPE = (40, 60)


def test_rest_is_quiet(make_truth):
    masks = find_strata(make_truth(np.full(SHAPE, -7.2), 0.0)).masks
    assert set(masks) == set(STRATA)
    assert masks["all"].all() and masks["quiet"].all()
    assert not masks["moving"].any() and not masks["complex"].any() and not masks["mixed"].any()


def test_moving_is_told_in_the_inertial_frame(make_truth):
    u = np.full(SHAPE, -5.0)
    u[:, :10] = -3.9
    u[:, 10:20] = -4.1
    strata = find_strata(make_truth(u, 0.0))
    assert strata.camera_u == -5
    assert strata.masks["moving"][:, :10].all()
    assert not strata.masks["moving"][:, 10:].any()


def test_the_truth_about_the_camera_goes_before_the_median(make_truth):
    u = np.full(SHAPE, -3.0)
    u[:, :10] = -5.0
    truth = make_truth(u, 0.0, camera_u=-5.0)
    strata = find_strata(truth)
    assert strata.camera_u == -5
    assert strata.masks["moving"][:, 10:].all() and not strata.masks["moving"][:, :10].any()


def test_no_soil_no_camera_motion(make_truth):
    assert camera_displacement(make_truth(np.ones(SHAPE), 0.0), np.zeros(SHAPE, bool)) == (0, 0)


def test_a_camera_that_shakes_vertically_moves_no_soil(make_truth):
    v = np.full(SHAPE, 2.0)
    v[:, :10] = 3.5
    truth = make_truth(np.full(SHAPE, -5.0), v, camera_u=-5.0, camera_v=2.0)
    strata = find_strata(truth)
    assert (strata.camera_u, strata.camera_v) == (-5, 2)
    assert strata.masks["moving"][:, :10].all() and not strata.masks["moving"][:, 10:].any()
    assert strata.masks["quiet"][:, 20:].all()
    assert (strata.motion[:, :, 20] == 0).all() and (strata.speed[:, 0] == 1.5).all()


def test_near_the_implement_is_complex(make_truth):
    distance = np.broadcast_to(np.arange(60, dtype=np.float32), SHAPE).copy()
    soil = distance > 0
    masks = find_strata(make_truth(np.zeros(SHAPE), 0.0, distance_to_implement=distance, soil=soil)).masks
    assert not masks["all"][:, 0].any()
    assert masks["complex"][:, 1:4].all()
    assert masks["quiet"][:, 4:].all()


@pytest.mark.parametrize(("shear", "is_complex"), [(0.09, False), (0.11, True)])
def test_shear_is_complex_above_its_bound(make_truth, shear, is_complex):
    u = shear * np.broadcast_to(np.arange(40.0)[:, None], SHAPE)
    masks = find_strata(make_truth(u, 0.0)).masks
    # In the first and last row there is no gradient, but one is within 3 px.
    assert (masks["complex"] == is_complex).all()


def test_within_three_pixels_of_a_jump_is_complex(make_truth):
    u = np.zeros(SHAPE)
    u[:, 30:] = 0.5  # central differences see it in columns 29 and 30
    masks = find_strata(make_truth(u, 0.0)).masks
    assert np.flatnonzero(masks["complex"][20]).tolist() == list(range(26, 34))


def test_gradient_needs_both_neighbours():
    u = np.zeros(SHAPE)
    u[:, 30:] = 1.0
    valid = np.ones(SHAPE, bool)
    norm = gradient_norm(u, np.zeros(SHAPE), valid)
    assert (norm[:, [29, 30]] == 0.5).all() and norm[:, :29].max() == 0
    valid[:, 30] = False
    u[:, 30] = np.nan
    norm = gradient_norm(u, np.zeros(SHAPE), valid)
    assert norm[valid].max() == 0


def test_gradient_of_a_rotation_is_frobenius():
    y, x = np.mgrid[:40, :60]
    norm = gradient_norm(-0.05 * y, 0.05 * x, np.ones(SHAPE, bool))
    assert norm[1:-1, 1:-1] == pytest.approx(0.05 * np.sqrt(2))


def test_unknown_motion_is_in_no_stratum(make_truth):
    valid = np.ones(SHAPE, bool)
    valid[0] = False
    u = np.zeros(SHAPE)
    u[1] = np.nan
    masks = find_strata(make_truth(u, 0.0, valid=valid, mixed=np.ones(SHAPE, bool))).masks
    for mask in masks.values():
        assert not mask[:2].any()
    assert masks["mixed"][2:].all()
