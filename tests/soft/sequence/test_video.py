import tracemalloc

import cv2
import numpy as np
import pytest

from soft import ImageSequence, SequenceError
from soft.sequence import video

SHAPE = (48, 64)


def film(path, levels, *, codec="FFV1", rate=12.5, shape=SHAPE):
    """A lossless film whose frames are of one grey level each, with a mark that tells left from right."""
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*codec), rate, shape[::-1])
    assert writer.isOpened(), codec
    for level in levels:
        frame = np.full((*shape, 3), level, np.uint8)
        frame[: shape[0] // 2, : shape[1] // 2] = 255 - level
        writer.write(frame)
    writer.release()
    return path


@pytest.mark.parametrize(
    ("name", "codec", "tolerance"),
    [("a.mkv", "FFV1", 1e-4), ("a.avi", "FFV1", 1e-4), ("a.avi", "MJPG", 3), ("a.mp4", "mp4v", 3)],
)
def test_frames_in_order(tmp_path, name, codec, tolerance):
    levels = [20, 60, 100, 140, 180]
    sequence = ImageSequence.open(film(tmp_path / name, levels, codec=codec))
    assert (len(sequence), sequence.shape) == (5, SHAPE)
    assert sequence.frame_rate == pytest.approx(12.5)
    assert not sequence.remark
    assert sequence.metres_per_pixel is None
    assert sequence.names[2] == f"{name}#2"
    for frame, level in zip(sequence, levels, strict=True):
        assert frame.dtype == np.float32
        assert np.abs(frame[30:, 40:] - level).max() <= tolerance
        assert np.abs(frame[:16, :16] - (255 - level)).max() <= tolerance


def test_rate_can_be_overridden(tmp_path):
    path = film(tmp_path / "a.mkv", [1, 2])
    assert ImageSequence.open(path, frame_rate=500).frame_rate == 500


def test_colour(tmp_path):
    writer = cv2.VideoWriter(str(tmp_path / "a.avi"), cv2.VideoWriter_fourcc(*"MJPG"), 5, SHAPE[::-1])
    for _ in range(2):
        writer.write(np.full((*SHAPE, 3), (0, 0, 250), np.uint8))
    writer.release()
    assert ImageSequence.open(tmp_path / "a.avi")[0].mean() == pytest.approx(0.299 * 250, abs=2)


def test_any_order_gives_the_same_frames(tmp_path):
    levels = list(range(0, 240, 20))
    sequence = ImageSequence.open(film(tmp_path / "a.mkv", levels))
    for index in (7, 3, 3, 11, 0, -1, 5):
        assert sequence[index][-1, -1] == pytest.approx(levels[index])
    with pytest.raises(IndexError):
        sequence[12]


def test_pairs_of_any_stride_are_read_forward(tmp_path, monkeypatch):
    opened = []
    reader = video._Reader
    monkeypatch.setattr(video, "_Reader", lambda path: opened.append(path) or reader(path))
    levels = list(range(0, 240, 20))
    sequence = ImageSequence.open(film(tmp_path / "a.mkv", levels)).select(stride=5)
    seen = [(a[-1, -1], b[-1, -1]) for a, b in sequence.picture_pairs()]
    assert np.allclose(seen, [(levels[i], levels[i + 5]) for i in range(7)])
    assert len(opened) == 2, "one reader for the first pictures, one for the second"


def test_memory_does_not_grow_with_the_film(tmp_path):
    peaks = []
    for count in (5, 60):
        sequence = ImageSequence.open(film(tmp_path / f"{count}.avi", [90] * count, codec="MJPG"))
        tracemalloc.start()
        for _ in sequence.picture_pairs():
            pass
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.2 * peaks[0]


def test_file_without_frames(tmp_path):
    path = film(tmp_path / "a.avi", [], codec="MJPG")
    with pytest.raises(SequenceError, match=r"a\.avi: (a video without a frame|not a readable video)"):
        ImageSequence.open(path)


def test_no_video_at_all(tmp_path):
    (tmp_path / "a.mp4").write_text("x")
    with pytest.raises(SequenceError, match=r"a\.mp4: not a readable video"):
        ImageSequence.open(tmp_path / "a.mp4")
    (tmp_path / "a.txt").write_text("x")
    with pytest.raises(SequenceError, match=r"a\.txt: is a file: expected a folder of pictures, or a video"):
        ImageSequence.open(tmp_path / "a.txt")


def test_one_lone_frame(tmp_path):
    with pytest.raises(SequenceError, match="1 picture: at least 2"):
        ImageSequence.open(film(tmp_path / "a.mkv", [7]))


def test_film_cut_short_ends_with_its_last_whole_frame(tmp_path):
    """What the header says counts for nothing: frames are counted."""
    path = film(tmp_path / "a.avi", range(0, 200, 10), codec="MJPG", shape=(240, 320))
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 2 // 3])
    sequence = ImageSequence.open(path)
    assert 2 <= len(sequence) < 20
    assert len(list(sequence)) == len(sequence)
    assert sequence.remark.startswith(f"a.avi: {len(sequence)} of the 20 frames that it tells of")
