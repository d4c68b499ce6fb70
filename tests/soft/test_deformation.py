import numpy as np
import pytest

from soft import Deformation, deformation_of, displacement_gradient

SHAPE = (90, 100)
Y, X = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
EVERYWHERE = np.ones(SHAPE, bool)


def affine(matrix, shift=(3.0, -1.0)):
    (a, b), (c, d) = matrix
    return np.stack([shift[0] + a * X + b * Y, shift[1] + c * X + d * Y], axis=-1)


@pytest.mark.parametrize("scale", [1.0, 3.0])
def test_an_affine_field_is_given_exactly_up_to_its_edges(scale):
    matrix = np.array([[0.02, -0.05], [0.03, 0.01]])
    measured = np.hypot(X - 50, Y - 20) > 18
    gradient = displacement_gradient(
        np.where(measured[..., None], affine(matrix), np.nan), measured, scale=scale
    )
    assert gradient.dtype == np.float32
    assert np.array_equal(np.isfinite(gradient).all(axis=(2, 3)), measured)
    assert np.allclose(gradient[measured], matrix, atol=1e-6)


def test_nothing_is_mixed_across_a_gap_of_one_pixel():
    """Soil on both sides of a thin grouser moves in different ways."""
    measured = X != 50
    displacement = np.where((X < 50)[..., None], affine([[0, 0.02], [0, 0]]), affine([[0, -0.1], [0.05, 0]]))
    gradient = displacement_gradient(displacement, measured, scale=4.0)
    assert np.allclose(gradient[:, :50], [[0, 0.02], [0, 0]], atol=1e-6)
    assert np.allclose(gradient[:, 51:], [[0, -0.1], [0.05, 0]], atol=1e-6)
    assert np.isnan(gradient[:, 50]).all()


def test_detail_is_smoothed_at_the_scale_that_is_stated():
    """Of a sine, the slope of the fit is that of the sine times the window's transfer function."""
    k, scale = 2 * np.pi / 30, 3.0
    u = np.stack([np.sin(k * X), np.zeros(SHAPE)], axis=-1)
    found = displacement_gradient(u, EVERYWHERE, scale=scale)[45, 30:70, 0, 0]
    dy, dx = np.mgrid[-6:7, -6:7]
    weight = np.where(np.hypot(dx, dy) <= 6, np.exp(-(dx**2 + dy**2) / (2 * scale**2)), 0)
    transfer = (weight * dx * np.sin(k * dx)).sum() / (weight * dx**2).sum()
    assert found == pytest.approx(transfer * np.cos(k * X[0, 30:70]), abs=1e-6)
    # Without the cut at twice the scale it would be a Gaussian's.
    assert k * np.exp(-((k * scale) ** 2) / 2) < transfer < k


def test_noise_is_reduced():
    noise = np.random.default_rng(0).normal(0, 0.1, (*SHAPE, 2))
    rough, smooth = (
        displacement_gradient(noise, EVERYWHERE, scale=s)[10:-10, 10:-10].std() for s in (1.0, 4.0)
    )
    # The slope's error falls with the square of the scale.
    assert rough / smooth == pytest.approx(16, rel=0.25)


def test_too_few_pixels_tell_nothing():
    line = Y == 30
    assert np.isnan(displacement_gradient(affine(np.eye(2)), line)).all()
    two = (Y == 30) | (Y == 31)
    assert np.isfinite(displacement_gradient(affine(np.eye(2)), two)[two]).all()


def test_simple_shear():
    parts = Deformation.from_gradient(displacement_gradient(affine([[0, 0.07], [0, 0]]), EVERYWHERE))
    assert np.allclose(parts.shear, 0.07, atol=1e-6)
    assert np.allclose(parts.strain_xy, 0.035, atol=1e-6)
    assert np.allclose(parts.dilation, 0, atol=1e-6)
    assert np.allclose(parts.rotation, -0.035, atol=1e-6)


def test_rotation_is_positive_clockwise_in_the_picture():
    angle = 0.02944
    spin = np.array([[np.cos(angle) - 1, -np.sin(angle)], [np.sin(angle), np.cos(angle) - 1]])
    parts = Deformation.from_gradient(displacement_gradient(affine(spin), EVERYWHERE))
    # x right turns towards y down.
    assert affine(spin)[0, 10, 1] > affine(spin)[0, 0, 1]
    assert np.allclose(parts.rotation, np.sin(angle), atol=1e-6)
    assert np.allclose(parts.shear, 0, atol=1e-6)


def test_dilation_and_pure_shear():
    swell = Deformation.from_gradient(displacement_gradient(affine([[0.03, 0], [0, 0.03]]), EVERYWHERE))
    assert np.allclose(swell.dilation, 0.06, atol=1e-6) and np.allclose(swell.shear, 0, atol=1e-6)
    pure = Deformation.from_gradient(displacement_gradient(affine([[0.03, 0], [0, -0.03]]), EVERYWHERE))
    assert np.allclose(pure.dilation, 0, atol=1e-6) and np.allclose(pure.shear, 0.06, atol=1e-6)
    assert np.allclose(pure.strain_xx, 0.03, atol=1e-6) and np.allclose(pure.strain_yy, -0.03, atol=1e-6)


def test_of_a_soil_flow(soil_flow):
    field = affine([[0, 0.07], [0, 0]])
    soil = np.broadcast_to(Y > 20, (1, *SHAPE))
    valid = np.broadcast_to(X > 10, (1, *SHAPE))
    parts = deformation_of(soil_flow(field[None, ..., 0], field[None, ..., 1], soil=soil, valid=valid))
    assert np.array_equal(np.isfinite(parts.shear), (Y > 20) & (X > 10))
    assert np.nanmax(np.abs(parts.shear - 0.07)) < 1e-5


def test_refused():
    with pytest.raises(ValueError, match="measured: shape"):
        displacement_gradient(affine(np.eye(2)), np.ones((3, 3), bool))
    with pytest.raises(ValueError, match="scale: 0"):
        displacement_gradient(affine(np.eye(2)), EVERYWHERE, scale=0)
