import cv2
import numpy as np
import pytest

from soft import ImageSequence, Region, SequenceError
from soft.sequence.resampling import Resampling


@pytest.fixture
def sequence():
    return ImageSequence.from_arrays([np.zeros((20, 30), np.uint8)] * 3)


def draw(path, box, shape=(20, 30)):
    picture = np.zeros(shape, np.uint8)
    picture[box] = 1
    path.parent.mkdir(exist_ok=True)
    cv2.imwrite(str(path), picture)
    return path


def test_one_for_all_frames(sequence, tmp_path):
    masked = sequence.mask(draw(tmp_path / "mask.png", np.s_[5:, :10]))
    expected = np.zeros((20, 30), bool)
    expected[5:, :10] = True
    assert all(np.array_equal(masked.usable(k), expected) for k in range(3))
    assert sequence.usable(0).all()
    masked.usable(0)[:] = False
    assert np.array_equal(masked.usable(0), expected)
    assert masked.files == (tmp_path / "mask.png",)
    assert masked.crop(Region(8, 4, 5, 6)).usable(0).sum() == 2 * 5


def test_one_for_each_frame(sequence, tmp_path):
    for k in range(3):
        draw(tmp_path / "masks" / f"m{9 + k}.png", np.s_[:, 10 * k : 10 * k + 5])
    masked = sequence.mask(tmp_path / "masks")
    assert [int(masked.usable(k).argmax()) for k in range(3)] == [0, 10, 20]


def test_masks_are_drawn_on_the_pictures_as_they_were_taken(sequence, tmp_path):
    y, x = np.mgrid[:20, :30].astype(np.float32)
    seen = sequence.resample(Resampling(np.stack([x + 3, y], axis=2), (20, 30)))
    masked = seen.mask(draw(tmp_path / "mask.png", np.s_[:, 10:]))
    assert np.array_equal(masked.usable(0)[0], (np.arange(30) >= 7) & (np.arange(30) < 27))


def test_a_photograph_is_no_mask_but_smooth_edges_are_fine(sequence, tmp_path):
    cv2.imwrite(str(tmp_path / "photo.png"), np.random.default_rng(0).integers(0, 256, (20, 30), np.uint8))
    with pytest.raises(SequenceError, match=r"photo\.png: has too many grey levels for something drawn"):
        sequence.mask(tmp_path / "photo.png").usable(0)
    drawn = np.zeros((20, 30), np.uint8)
    drawn[5:, :] = 255
    drawn[5, :20] = np.arange(20) * 10 + 20
    cv2.imwrite(str(tmp_path / "smooth.png"), drawn)
    assert sequence.mask(tmp_path / "smooth.png").usable(0)[5:].all()


def test_what_does_not_fit(sequence, tmp_path):
    with pytest.raises(SequenceError, match="30 x 21 px, but the pictures have 30 x 20 px"):
        sequence.mask(draw(tmp_path / "a.png", np.s_[:], (21, 30)))
    with pytest.raises(SequenceError, match="allowed are png, tif, tiff, bmp, which keep black black"):
        sequence.mask(draw(tmp_path / "a.jpg", np.s_[:]))
    with pytest.raises(SequenceError, match="neither a picture nor a folder"):
        sequence.mask(tmp_path / "none.png")
    draw(tmp_path / "two" / "1.png", np.s_[:])
    draw(tmp_path / "two" / "2.png", np.s_[:])
    with pytest.raises(SequenceError, match="2 pictures for 3 frames"):
        sequence.mask(tmp_path / "two")
