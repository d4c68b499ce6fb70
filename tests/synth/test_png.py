import cv2
import numpy as np
import pytest
from PIL import Image

from synth.png import png_bytes


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("shape", [(1, 1), (37, 53), (300, 200)])
def test_two_readers_read_the_same_values(tmp_path, dtype, shape):
    picture = np.random.default_rng(3).integers(0, np.iinfo(dtype).max, shape, dtype, endpoint=True)
    path = tmp_path / "picture.png"
    path.write_bytes(png_bytes(picture))
    read = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    assert read.dtype == dtype
    assert np.array_equal(read, picture)
    assert np.array_equal(np.asarray(Image.open(path)), picture)


def test_a_part_of_a_picture_is_written_as_it_looks(tmp_path):
    picture = np.arange(200, dtype=np.uint8).reshape(10, 20)
    path = tmp_path / "picture.png"
    path.write_bytes(png_bytes(picture[2:7, 3::2]))
    assert np.array_equal(cv2.imread(str(path), cv2.IMREAD_UNCHANGED), picture[2:7, 3::2])


def test_a_smooth_picture_is_small():
    assert len(png_bytes(np.full((500, 400), 90, np.uint8))) < 2_000


@pytest.mark.parametrize("picture", [np.zeros((4, 5, 3), np.uint8), np.zeros((4, 5), np.float32)])
def test_what_is_not_grey_levels_is_refused(picture):
    with pytest.raises(ValueError, match="grey of 8 or 16 bit"):
        png_bytes(picture)
