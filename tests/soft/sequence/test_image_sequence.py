import cv2
import numpy as np
import pytest

from soft import ImageSequence, SequenceError

TOML = """schema_version = 1
frame_rate = 8.0
metres_per_pixel = 2e-4
frames = ["frames/0.png", "frames/1.png"]
"""


def write(path, picture):
    path.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(path), picture)


@pytest.fixture
def footage(tmp_path):
    for k in range(2):
        write(tmp_path / "frames" / f"{k}.png", np.full((20, 30), 10 + k, np.uint8))
    (tmp_path / "sequence.toml").write_text(TOML)
    return tmp_path


def test_footage_folder(footage):
    sequence = ImageSequence.open(footage)
    assert len(sequence) == 2
    assert sequence.shape == (20, 30)
    assert sequence.pairs == ((0, 1),)
    assert (sequence.frame_rate, sequence.metres_per_pixel, sequence.time_step) == (8.0, 2e-4, 0.125)
    assert sequence[1].dtype == np.float32
    assert (sequence[1] == 11).all()
    assert ImageSequence.open(footage, frame_rate=4).frame_rate == 4.0


def test_own_pictures_in_natural_order_and_nothing_else(tmp_path):
    for k in (10, 2, 1):
        write(tmp_path / f"Shot{k}.PNG", np.full((4, 5), k, np.uint8))
    (tmp_path / "notes.txt").write_text("x")
    (tmp_path / ".hidden.png").write_text("x")
    sequence = ImageSequence.open(tmp_path)
    assert [int(frame[0, 0]) for frame in sequence] == [1, 2, 10]
    assert not sequence.calibrated
    assert sequence.time_step is None


def test_depth_and_colour(tmp_path):
    blue_green_red = np.zeros((4, 5, 3), np.uint8)
    blue_green_red[:, :, 2] = 200
    write(tmp_path / "1.png", blue_green_red)
    write(tmp_path / "2.png", np.full((4, 5), 65535, np.uint16))
    write(tmp_path / "3.tif", np.full((4, 5), 257, np.uint16))
    write(tmp_path / "4.bmp", np.full((4, 5), 7, np.uint8))
    write(tmp_path / "5.jpg", np.full((4, 5), 90, np.uint8))
    write(tmp_path / "6.png", np.full((4, 5, 4), 255, np.uint8))
    levels = [float(frame[0, 0]) for frame in ImageSequence.open(tmp_path)]
    assert levels == pytest.approx([0.299 * 200, 255.0, 1.0, 7.0, 90.0, 255.0], abs=1e-4)


def test_colour_jpeg_is_read_in_the_right_order(tmp_path):
    for k in (1, 2):
        write(tmp_path / f"{k}.jpg", np.full((16, 16, 3), (0, 0, 250), np.uint8))
    assert ImageSequence.open(tmp_path)[0].mean() == pytest.approx(0.299 * 250, abs=2)


def test_arrays(moved):
    first, second, _ = moved()
    sequence = ImageSequence.from_arrays([first, second], frame_rate=2, metres_per_pixel=1e-3)
    assert sequence.calibrated
    sequence[0][:] = 0
    assert np.array_equal(sequence[0], first)
    with pytest.raises(IndexError):
        sequence[2]
    with pytest.raises(SequenceError, match=r"picture 1: 100 x 160 px, but the first picture has 220 x 160"):
        ImageSequence.from_arrays([first, second[:, :100]])
    with pytest.raises(SequenceError, match="int64"):
        ImageSequence.from_arrays([first.astype(int), second])


def test_missing_folder_and_file(tmp_path):
    with pytest.raises(SequenceError, match="does not exist"):
        ImageSequence.open(tmp_path / "nowhere")
    (tmp_path / "a.png").write_text("x")
    with pytest.raises(SequenceError, match="is a file"):
        ImageSequence.open(tmp_path / "a.png")


def test_no_picture_and_one_lone_picture(tmp_path):
    with pytest.raises(SequenceError, match=r"no picture in it: allowed are png, jpg"):
        ImageSequence.open(tmp_path)
    write(tmp_path / "1.png", np.zeros((4, 5), np.uint8))
    with pytest.raises(SequenceError, match="1 picture: at least 2"):
        ImageSequence.open(tmp_path)


def test_odd_sized_picture_is_found_on_opening(tmp_path):
    for k in range(3):
        write(tmp_path / f"{k}.png", np.zeros((4, 5 + (k == 2)), np.uint8))
    with pytest.raises(SequenceError, match=r"2\.png: 6 x 4 px, but the first picture has 5 x 4 px"):
        ImageSequence.open(tmp_path)


@pytest.mark.parametrize("suffix", ["png", "jpg", "tif", "bmp"])
def test_picture_cut_short_is_an_error_not_grey(tmp_path, suffix):
    noise = np.random.default_rng(0).integers(0, 255, (64, 64)).astype(np.uint8)
    for k in (1, 2):
        write(tmp_path / f"{k}.{suffix}", noise)
    damaged = tmp_path / f"2.{suffix}"
    damaged.write_bytes(damaged.read_bytes()[:2000])
    with pytest.raises(SequenceError, match=rf"2\.{suffix}: not a readable picture"):
        ImageSequence.open(tmp_path)[1]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("schema_version = 1", "schema_version = 2", "schema_version 2: this reads 1"),
        ("schema_version = 1", "", "schema_version is missing"),
        ("frame_rate = 8.0", "frame_rate = 0", "frame_rate: 0: must be a number above 0"),
        ("metres_per_pixel = 2e-4", "metres_per_pixel = 'a'", "metres_per_pixel: 'a'"),
        ("frames/0.png", "../0.png", "must lie inside the folder"),
        ("frames/0.png", "/etc/0.png", "must lie inside the folder"),
        ("frames/0.png", "frames/7.png", r"7\.png: no such picture"),
        ('["frames/0.png", "frames/1.png"]', '["frames/0.png"]', "1 picture: at least 2"),
        ('["frames/0.png", "frames/1.png"]', "3", "must be a list"),
        ("frames =", "frames", "not valid TOML"),
    ],
)
def test_bad_sequence_file(footage, old, new, message):
    assert old in TOML
    (footage / "sequence.toml").write_text(TOML.replace(old, new))
    with pytest.raises(SequenceError, match=message) as caught:
        ImageSequence.open(footage)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("value", [0, -1.0, float("nan"), float("inf"), True])
def test_impossible_calibration(footage, value):
    with pytest.raises(SequenceError, match="must be a number above 0"):
        ImageSequence.open(footage, metres_per_pixel=value)


def test_colour_white_is_white_exactly():
    for dtype, white in ((np.uint8, 255), (np.uint16, 65535)):
        pictures = [np.full((3, 3, 3), white, dtype)] * 2
        assert ImageSequence.from_arrays(pictures)[0].max() <= 255
