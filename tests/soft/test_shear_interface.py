import csv

import numpy as np
import pytest

from soft import (
    ShearInterface,
    average_flow,
    moving_mask,
    shear_interface_of,
    shear_interface_of_mean,
    write_interface,
)
from soft.shear_interface import shear_interface

SHAPE = (120, 160)
CENTRE = (80.3, 58.6)
Y, X = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
RADIUS = np.hypot(X - CENTRE[0], Y - CENTRE[1])


def radius_of(line):
    return np.hypot(line[:, 0] - CENTRE[0], line[:, 1] - CENTRE[1])


def test_a_circle_to_a_fraction_of_a_pixel():
    speed = np.clip(4.0 - 0.1 * RADIUS, 0, None)
    found = shear_interface(speed, speed > 1.63, threshold=1.63)
    (line,) = found.lines
    assert line.dtype == np.float64
    assert np.array_equal(line[0], line[-1])
    assert np.abs(radius_of(line) - 23.7).max() < 0.01
    assert found.length == pytest.approx(2 * np.pi * 23.7, rel=0.01)
    assert "1 line, 149 px long" in found.remark


def test_x_and_y_are_not_swapped():
    speed = np.where(X < 40.25, 2.0, 0.0)
    (line,) = shear_interface(speed, speed > 1, threshold=1.0).lines
    assert np.allclose(line[:, 0], 40.5)
    assert (line[:, 1].min(), line[:, 1].max()) == (0.0, SHAPE[0] - 1)


def test_the_implement_and_the_border_are_no_shear_interface():
    """Moving soil below an implement that takes the upper rows, at the picture's left border."""
    soil = Y >= 30
    speed = np.where(soil, np.clip(4.0 - 0.1 * np.hypot(X - 10, Y - 30), 0, None), np.nan)
    moving = soil & (np.nan_to_num(speed) > 1.0)
    (line,) = shear_interface(speed, moving, threshold=1.0, soil=soil).lines
    assert np.abs(np.hypot(line[:, 0] - 10, line[:, 1] - 30) - 30).max() < 0.02
    assert line[:, 1].min() == pytest.approx(30 + 3, abs=0.51)  # to within the margin of the implement
    assert line[:, 0].min() == pytest.approx(0, abs=0.01)
    ends = sorted([tuple(line[0]), tuple(line[-1])])
    assert ends[0][0] == pytest.approx(0, abs=0.01) and ends[1][0] > 39


def test_no_margin_cuts_at_the_outline_itself():
    soil = Y >= 30
    speed = np.where(soil, np.where(X < 40, 2.0, 0.0), np.nan)
    (line,) = shear_interface(speed, soil & (X < 40), threshold=1.0, margin=0.0).lines
    assert line[:, 1].min() == 30


def test_where_a_gap_was_filled_the_line_is_half_way():
    speed = np.where(X < 40, 2.0, 0.0)
    speed[50:53, 35:40] = 0.0  # slow, but within the region, whose gaps are filled
    (line,) = shear_interface(speed, X < 40, threshold=1.0).lines
    assert np.allclose(line[:, 0], 39.5)


def test_unmeasured_soil_does_not_cut_the_line_when_told_that_it_is_soil():
    speed = np.where(X < 40, 2.0, 0.0)
    speed[50:53, 38:44] = np.nan
    assert len(shear_interface(speed, X < 40, threshold=1.0).lines) == 2
    (line,) = shear_interface(speed, X < 40, threshold=1.0, soil=np.ones(SHAPE, bool)).lines
    assert np.allclose(line[:, 0], 39.5)


def test_where_nothing_was_measured_there_is_no_shear_interface():
    """What moves ends at a wide strip without measurements, and at resting soil below it."""
    speed = np.where(Y < 70, 2.0, 0.0)
    speed[:, 100:] = np.nan
    (line,) = shear_interface(speed, np.nan_to_num(speed) > 1, threshold=1.0, soil=np.ones(SHAPE, bool)).lines
    assert np.allclose(line[:, 1], 69.5)
    assert line[:, 0].max() == 100 - 1 - 3


def test_a_closed_line_is_cut_only_where_it_meets_the_implement():
    soil = np.hypot(X - 80, Y - 20) > 12
    moving = soil & (RADIUS < 40)
    speed = np.where(soil, np.where(moving, 2.0, 0.0), np.nan)
    (line,) = shear_interface(speed, moving, threshold=1.0).lines
    assert np.abs(radius_of(line) - 40).max() < 1
    assert not np.array_equal(line[0], line[-1])
    assert np.hypot(*np.diff(line, axis=0).T).max() < 1.5


@pytest.mark.parametrize("moving", [np.zeros(SHAPE, bool), np.ones(SHAPE, bool)])
def test_no_line_and_why(moving):
    found = shear_interface(np.ones(SHAPE), moving, threshold=0.5)
    assert found.lines == ()
    assert "no shear interface" in found.remark or "no resting soil" in found.remark


def test_shapes_must_agree():
    with pytest.raises(ValueError, match="moving: shape"):
        shear_interface(np.ones(SHAPE), np.ones((3, 3), bool), threshold=0.5)


def test_with_the_moving_region_as_found():
    """Two-means on a disc that moves by 3 px: the line runs where the disc ends."""
    noise = np.random.default_rng(0).normal(0, 0.05, (2, *SHAPE))
    speed = np.hypot(noise[0] + 3.0 * (RADIUS < 35), noise[1])
    region = moving_mask(speed, np.ones(SHAPE, bool))
    (line,) = shear_interface(speed, region.mask, threshold=region.threshold).lines
    assert np.abs(radius_of(line) - 35).max() < 1.0


def test_of_a_soil_flow_and_of_its_mean(soil_flow):
    """A disc that moves by 0.3 px under errors of 0.15: no pair shows it, the mean over 64 does."""
    noise = np.random.default_rng(0).normal(0, 0.15, (64, 2, *SHAPE))
    flow = soil_flow(0.3 * (RADIUS < 35) + noise[:, 0], noise[:, 1])
    assert shear_interface_of(flow, pair=3).lines == ()
    assert "no moving region" in shear_interface_of(flow, pair=3).remark
    (line,) = shear_interface_of_mean(average_flow(flow)).lines
    assert np.abs(radius_of(line) - 35).max() < 1.0
    fast = soil_flow(3.0 * (RADIUS < 35) + noise[:2, 0], noise[:2, 1])
    (line,) = shear_interface_of(fast, pair=1).lines
    assert np.abs(radius_of(line) - 35).max() < 1.0


def test_written_and_read(tmp_path):
    lines = (np.array([[1.0, 2.0], [3.25, 4.5]]), np.array([[10.0, 20.0], [11.0, 21.0], [12.0, 22.0]]))
    write_interface(ShearInterface(lines, ""), tmp_path / "line.csv", metres_per_pixel=2e-4)
    with (tmp_path / "line.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["line"] for row in rows] == ["0", "0", "1", "1", "1"]
    assert (float(rows[1]["x_px"]), float(rows[1]["y_px"])) == (3.25, 4.5)
    assert (float(rows[1]["x_m"]), float(rows[1]["y_m"])) == pytest.approx((3.25 * 2e-4, 4.5 * 2e-4))
    write_interface(ShearInterface(lines, ""), tmp_path / "px.csv")
    assert (tmp_path / "px.csv").read_text().splitlines()[0] == "line,x_px,y_px"
