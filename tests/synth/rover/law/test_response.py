import numpy as np
import pytest

from synth.rover.law.response import SoilError, generic_response, published_scale


def plate(tilt, attack):
    """Generic force (x, z) on a plate: tilt 0 level, 90 a wall facing +x; attack 90 straight down (deg)."""
    beta, gamma = np.broadcast_arrays(np.radians(tilt), np.radians(attack))
    normal, velocity = (np.sin(beta), -np.cos(beta)), (np.cos(gamma), -np.sin(gamma))
    response = generic_response(*normal, *velocity)
    tangent = -normal[1], normal[0]
    return tuple(
        response.shear * along - response.pressure * out for along, out in zip(tangent, normal, strict=True)
    )


def li_2013(tilt, attack):
    """The same after C. Li, T. Zhang, D. Goldman, Science 339, 2013: its generic Fourier coefficients."""
    beta, gamma = np.radians(tilt), np.radians(attack)
    z = 0.206 + 0.169 * np.cos(2 * beta) + 0.212 * np.sin(2 * beta + gamma)
    z += 0.358 * np.sin(gamma) + 0.055 * np.sin(gamma - 2 * beta)
    x = -0.124 * np.cos(2 * beta + gamma) + 0.253 * np.cos(gamma)
    x += 0.007 * np.cos(gamma - 2 * beta) + 0.088 * np.sin(2 * beta)
    return -x, z


def leading_plates():
    tilt, attack = np.meshgrid(np.linspace(-90, 90, 37), np.linspace(-90, 90, 37))
    leads = np.sin(np.radians(tilt + attack)) > 0.05
    return tilt[leads], attack[leads]


def test_a_level_plate_pressed_down_meets_the_papers_value():
    x, z = plate(0.0, 90.0)
    assert x == pytest.approx(0, abs=1e-12)
    assert z == pytest.approx(0.87574, abs=1e-5)


def test_it_agrees_with_the_generic_response_that_was_measured_ten_years_before():
    # Fitted to other data with other functions: a wrong coefficient shows.
    tilt, attack = leading_plates()
    ours, theirs = np.concatenate(plate(tilt, attack)), np.concatenate(li_2013(tilt, attack))
    assert np.sqrt(np.mean((ours - theirs) ** 2)) < 0.1 * np.abs(theirs).max()
    assert ours @ theirs / (theirs @ theirs) == pytest.approx(1, abs=0.1)


def test_it_always_pushes_a_leading_surface_back_and_takes_work():
    tilt, attack = leading_plates()
    x, z = plate(tilt, attack)
    beta, gamma = np.radians(tilt), np.radians(attack)
    assert np.all(x * np.sin(beta) - z * np.cos(beta) < 0)
    assert np.all(x * np.cos(gamma) - z * np.sin(gamma) < 0)


def test_mirror_images_meet_mirrored_forces():
    tilt, attack = leading_plates()
    x, z = plate(tilt, attack)
    mirrored_x, mirrored_z = plate(-tilt, 180 - attack)
    np.testing.assert_allclose(mirrored_x, -x, atol=1e-12)
    np.testing.assert_allclose(mirrored_z, z, atol=1e-12)


def test_scale_grows_with_density_and_friction_and_refuses_what_was_not_fitted():
    loose = published_scale(density=1620, friction_angle=32)
    assert published_scale(density=3240, friction_angle=32) == pytest.approx(2 * loose)
    assert published_scale(density=1620, friction_angle=36) > 1.4 * loose
    with pytest.raises(SoilError, match=r"friction_angle = 10: 16\.7 to 42\.0 deg is allowed"):
        published_scale(density=1620, friction_angle=10)
