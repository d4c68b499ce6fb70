import struct

import numpy as np
import pytest

from soft.flow import FlowError, read_flo, write_flo


def test_round_trip_and_unknown(tmp_path):
    flow = np.random.default_rng(0).normal(size=(5, 7, 2)).astype(np.float32)
    flow[2, 3] = np.nan
    flow[4, 6, 1] = np.nan
    write_flo(tmp_path / "a.flo", flow)
    back = read_flo(tmp_path / "a.flo")
    flow[4, 6] = np.nan
    assert np.array_equal(back, flow, equal_nan=True)


def test_bytes_are_middleburys(tmp_path):
    write_flo(tmp_path / "a.flo", np.arange(12).reshape(2, 3, 2))
    assert (tmp_path / "a.flo").read_bytes() == b"PIEH" + struct.pack("<2i12f", 3, 2, *range(12))
    (tmp_path / "b.flo").write_bytes(b"PIEH" + struct.pack("<2i4f", 2, 1, 1, 2, 3, -2e9))
    assert np.array_equal(read_flo(tmp_path / "b.flo"), [[[1, 2], [np.nan, np.nan]]], equal_nan=True)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"PIEH", "not a Middlebury"),
        (b"HEIP" + bytes(16), "not a Middlebury"),
        (b"PIEH" + struct.pack("<2i", 3, 2), "12 bytes: 3 x 2 px need 60"),
        (b"PIEH" + struct.pack("<2i", -1, -1), "need"),
    ],
)
def test_damaged(tmp_path, content, message):
    (tmp_path / "a.flo").write_bytes(content)
    with pytest.raises(FlowError, match=message):
        read_flo(tmp_path / "a.flo")


def test_missing_and_misshapen(tmp_path):
    with pytest.raises(FlowError, match="cannot be read"):
        read_flo(tmp_path / "a.flo")
    with pytest.raises(FlowError, match="must be"):
        write_flo(tmp_path / "a.flo", np.zeros((2, 3)))
