import numpy as np
import pytest

from soft import ImageSequence
from soft.calibration import CalibrationError, Lens, calibrate_glass, metres_per_pixel_between

from .conftest import DISTORTION, MATRIX, SHAPE

CORNERS = np.array([[-0.1, -0.06], [0.1, -0.06], [0.1, 0.06], [-0.1, 0.06]])
INNER = np.array([[0.0, 0.0], [0.05, 0.02], [-0.07, 0.03], [0.02, -0.05]])


def pose_of(tilt, distance=0.42):
    """Of a thing whose y points down in the picture, turned about the vertical."""
    return ((0.0, tilt, 0.0), (0.0, 0.0, distance))


def seen_by_a_pinhole(world, tilt, distance=0.42):
    """Px of points (x, z up) on glass that is turned about the vertical by `tilt`."""
    x, z = np.asarray(world, float).T
    depth = distance - np.sin(tilt) * x
    return np.stack(
        [MATRIX[0, 0] * np.cos(tilt) * x / depth + MATRIX[0, 2], -MATRIX[1, 1] * z / depth + MATRIX[1, 2]], 1
    )


def test_scale():
    assert metres_per_pixel_between((10, 20), (40, 60), length=0.1) == pytest.approx(0.002)
    with pytest.raises(CalibrationError, match="must be two points"):
        metres_per_pixel_between((1, 1), (1, 1), length=0.1)
    with pytest.raises(CalibrationError, match="scale length: -1: must be above 0 m"):
        metres_per_pixel_between((1, 1), (1, 2), length=-1)


@pytest.mark.parametrize("tilt", [0.0, 0.1, -0.3])
def test_tilt_and_places_of_a_known_view(tilt):
    lens = Lens(SHAPE, MATRIX, np.zeros(5))
    world = np.concatenate([CORNERS, INNER])
    glass = calibrate_glass(seen_by_a_pinhole(world, tilt), world, shape=SHAPE, lens=lens)
    assert glass.tilt == pytest.approx(abs(tilt), abs=1e-6)
    assert glass.residual < 1e-6
    assert np.allclose(glass.to_glass(seen_by_a_pinhole(INNER, tilt)), INNER, atol=1e-9)
    assert np.allclose(glass.to_pixels(INNER), seen_by_a_pinhole(INNER, tilt), atol=1e-6)
    if tilt == 0:
        assert glass.metres_per_pixel == pytest.approx(0.42 / np.sqrt(520 * 515), rel=1e-6)
        assert glass.scale_spread < 1e-6
    else:
        assert glass.scale_spread > 0.05


def test_without_a_lens_the_tilt_is_not_told():
    glass = calibrate_glass(seen_by_a_pinhole(CORNERS, 0.1), CORNERS, shape=SHAPE)
    assert glass.tilt is None
    assert glass.residual < 1e-6


def test_residual_tells_what_does_not_fit():
    world = np.concatenate([CORNERS, INNER])
    rng = np.random.default_rng(0)
    noise = rng.normal(0, 0.5, (8, 2))
    glass = calibrate_glass(seen_by_a_pinhole(world, 0.1) + noise, world, shape=SHAPE)
    # Eight of the sixteen numbers are taken by the homography.
    assert glass.residual == pytest.approx(0.5 * np.sqrt(2) * np.sqrt(8 / 16), rel=0.4)
    assert glass.residual_max >= glass.residual


def test_points_through_a_lens(photographer, true_lens):
    world = np.concatenate([CORNERS, INNER])
    pose = pose_of(0.2)
    pixels = photographer.place(world * [1, -1], pose)
    glass = calibrate_glass(pixels, world, shape=SHAPE, lens=true_lens)
    assert glass.residual < 1e-3
    assert glass.tilt == pytest.approx(0.2, abs=1e-4)
    assert calibrate_glass(pixels, world, shape=SHAPE).residual > 0.3, "what ignoring the lens leaves"


def test_rectified_pictures_show_the_glass_in_scale(photographer, true_lens):
    """Stripes along x and z on a tilted glass, through the lens: in scale and in place once rectified."""

    def paint(x, y):
        return 128 + 50 * np.cos(2 * np.pi * x / 0.02) + 50 * np.cos(2 * np.pi * y / 0.015)

    pose = pose_of(0.25)
    picture = photographer.picture(paint, pose)
    world = np.concatenate([CORNERS, INNER])
    pixels = photographer.place(world * [1, -1], pose)
    glass = calibrate_glass(pixels, world, shape=SHAPE, lens=true_lens)
    view = glass.rectification(0.0008)
    sequence = ImageSequence.from_arrays([picture, picture]).resample(
        view.resampling, metres_per_pixel=view.metres_per_pixel
    )
    assert sequence.metres_per_pixel == 0.0008
    row, column = np.indices(sequence.shape)
    x, z = view.left + 0.0008 * column, view.top - 0.0008 * row
    inner = (np.abs(x) < 0.12) & (np.abs(z) < 0.1) & sequence.seen
    assert inner.sum() > 20_000
    off = (sequence[0] - paint(x, -z))[inner]
    # A quarter of a pixel (0.2 mm) off, stripes of 15 mm would differ by 3 grey levels on average.
    assert np.abs(off).mean() < 0.7


def test_points_that_are_not_enough():
    pixels = seen_by_a_pinhole(CORNERS, 0)
    with pytest.raises(CalibrationError, match="3 in the picture and 3 on the glass: needed are 4"):
        calibrate_glass(pixels[:3], CORNERS[:3], shape=SHAPE)
    line = np.array([[0, 0], [0.1, 0.05], [0.2, 0.1], [0.3, 0.9]])
    with pytest.raises(CalibrationError, match="too many lie on one line"):
        calibrate_glass(seen_by_a_pinhole(line, 0), line, shape=SHAPE)
    with pytest.raises(CalibrationError, match="pairs of finite numbers"):
        calibrate_glass(pixels * np.nan, CORNERS, shape=SHAPE)
    with pytest.raises(CalibrationError, match="480 x 360 px, but these have 40 x 30 px"):
        calibrate_glass(pixels, CORNERS, shape=(30, 40), lens=Lens(SHAPE, MATRIX, DISTORTION))


def test_glass_seen_from_the_side():
    tilt = 1.35
    pixels = seen_by_a_pinhole(CORNERS, tilt)
    glass = calibrate_glass(pixels, CORNERS, shape=SHAPE)
    with pytest.raises(CalibrationError, match="too obliquely"):
        glass.rectification()
