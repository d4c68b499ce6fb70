import numpy as np

from validation.scoring.shear_line import shear_line

SHAPE = (160, 220)
Y, X = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)


def test_the_middle_of_a_slanted_band():
    off = (Y - 40 - 0.5 * X) / np.hypot(1, 0.5)
    points = shear_line(0.2 / np.cosh(off / 8) ** 2, Y > 20)
    assert len(points) > 150
    distance = np.abs(points[:, 1] - 40 - 0.5 * points[:, 0]) / np.hypot(1, 0.5)
    assert distance.max() < 1.0


def test_bands_of_little_shear_and_of_the_implements_rim_are_left_out():
    soil = Y > 20
    rate = 0.2 / np.cosh((Y - 100) / 6) ** 2 + 0.04 / np.cosh((Y - 60) / 6) ** 2 + 0.5 * (Y < 24)
    points = shear_line(np.where(soil, rate, np.nan), soil)
    assert np.abs(points[:, 1] - 100).max() <= 1


def test_nothing_shears():
    assert shear_line(np.zeros(SHAPE), np.ones(SHAPE, bool)).shape == (0, 2)
    assert shear_line(np.ones(SHAPE), np.zeros(SHAPE, bool)).shape == (0, 2)
