import cv2
import numpy as np
import pytest

from soft import FlowError, read_kitti, write_kitti
from soft.flow.kitti import QUANTUM


def test_values_come_back_within_half_a_quantum(tmp_path):
    flow = np.random.default_rng(0).uniform(-500, 500, (7, 9, 2)).astype(np.float32)
    flow[2, 3] = np.nan
    write_kitti(tmp_path / "x.png", flow)
    back = read_kitti(tmp_path / "x.png")
    assert back.dtype == np.float32
    assert np.nanmax(np.abs(back - flow)) <= QUANTUM / 2
    assert np.array_equal(np.isnan(back), np.isnan(flow))


def test_the_file_is_as_the_development_kit_says(tmp_path):
    flow = np.zeros((4, 5, 2), np.float32)
    flow[1, 2] = 3.0, -2.5  # right and up
    flow[3, 4] = np.nan
    write_kitti(tmp_path / "x.png", flow)
    blue, green, red = np.moveaxis(cv2.imread(str(tmp_path / "x.png"), cv2.IMREAD_UNCHANGED), -1, 0)
    assert (red[1, 2], green[1, 2], blue[1, 2]) == (32768 + 192, 32768 - 160, 1)
    assert (red[3, 4], green[3, 4], blue[3, 4]) == (0, 0, 0)
    assert (red[0, 0], green[0, 0], blue[0, 0]) == (32768, 32768, 1)


def test_the_ends_of_the_range(tmp_path):
    flow = np.full((2, 2, 2), -512.0)
    flow[0] = 512 - QUANTUM
    write_kitti(tmp_path / "x.png", flow)
    assert np.array_equal(read_kitti(tmp_path / "x.png"), flow)
    for beyond in (512.0, -512.1):
        with pytest.raises(FlowError, match=r"displacement of 512\.\d px: KITTI's 16 bit hold less than 512"):
            write_kitti(tmp_path / "y.png", np.full((2, 2, 2), beyond))


def test_what_is_none_is_refused(tmp_path):
    with pytest.raises(FlowError, match="no such file"):
        read_kitti(tmp_path / "none.png")
    cv2.imwrite(str(tmp_path / "grey.png"), np.zeros((4, 4), np.uint8))
    with pytest.raises(FlowError, match=r"grey\.png: not a KITTI flow picture"):
        read_kitti(tmp_path / "grey.png")
    with pytest.raises(FlowError, match=r"shape \(4, 4\)"):
        write_kitti(tmp_path / "x.png", np.zeros((4, 4)))
