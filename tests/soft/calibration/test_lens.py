from functools import cache

import cv2
import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from soft import ImageSequence, analyze
from soft.calibration import CalibrationError, CharucoBoard, Chessboard, Lens, calibrate_lens

from .conftest import DISTORTION, MATRIX, POSES, SHAPE

CHESSBOARD = Chessboard(9, 6, 0.025)
CHARUCO = CharucoBoard(10, 7, 0.025, 0.018, "DICT_4X4_50")


def paint_chessboard(x, y):
    """Its middle at the origin; edges are as soft as a pixel is wide, as a lens makes them."""
    across, down = x + 0.1, y + 0.0625
    edge = 0.025 / (np.pi * 0.0006)
    squares = np.tanh(edge * np.sin(np.pi * across / 0.025)) * np.tanh(edge * np.sin(np.pi * down / 0.025))
    on_board = (across > -0.025) & (across < 0.225) & (down > -0.025) & (down < 0.15)
    return np.where(on_board, 125 - 95 * squares, 220.0)


@cache
def printed_charuco():
    """As OpenCV prints it, 60 px a square and a margin of one, with soft edges."""
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    board = cv2.aruco.CharucoBoard((10, 7), 0.025, 0.018, dictionary)
    grey = 30 + 190.0 * (board.generateImage((720, 540), marginSize=60) > 127)
    return cv2.GaussianBlur(grey, (0, 0), 1.5)


def paint_charuco(x, y):
    """Its middle at the origin; the px of a print have their centres at whole numbers, too."""
    column, row = x / 0.025 * 60 + 359.5, y / 0.025 * 60 + 269.5
    return map_coordinates(printed_charuco(), [row, column], order=1, mode="nearest")


KINDS = {
    "chessboard": (CHESSBOARD, paint_chessboard, (0.1, 0.0625)),
    "charuco": (CHARUCO, paint_charuco, (0.125, 0.0875)),
}


@pytest.fixture(scope="module", params=KINDS)
def views(request, photographer):
    """A board, its pictures, and where its origin lies on what was painted."""
    board, paint, origin = KINDS[request.param]
    return board, [(f"{k}.png", photographer.picture(paint, pose)) for k, pose in enumerate(POSES)], origin


def test_corners_are_found_where_they_are(views, photographer):
    """Half a pixel off, every corner would be, the same way: so the mean tells the convention."""
    board, pictures, origin = views
    off = []
    for (_, picture), pose in zip(pictures, POSES, strict=True):
        places, corners = board.find(picture)
        true = photographer.place(places[:, :2] - origin, pose)
        turned = photographer.place(origin - places[:, :2], pose)
        if np.abs(corners - turned).max() < np.abs(corners - true).max():
            true = turned  # a chessboard looks the same from either end
        off.append(corners - true)
    off = np.concatenate(off)
    assert np.abs(off.mean(axis=0)).max() < 0.03
    assert np.sqrt((off**2).sum(axis=1).mean()) < 0.12


def test_lens_is_recovered(views, true_lens):
    board, pictures, _ = views
    lens = calibrate_lens([*pictures, ("blank.png", np.full(SHAPE, 128, np.float32))], board)
    assert lens.shape == SHAPE
    assert len(lens.views) == len(POSES)
    assert lens.reprojection_error < 0.12
    assert lens.camera_matrix[0, 0] == pytest.approx(MATRIX[0, 0], rel=0.003)
    assert lens.camera_matrix[:2, 2] == pytest.approx(MATRIX[:2, 2], abs=1.5)
    # What counts: straight lines. Wherever the principal point is put, up to a view of a plane.
    y, x = np.mgrid[40:320:8j, 50:430:10j]
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    found, true = lens.undistorted(points), true_lens.undistorted(points)
    same_view, _ = cv2.findHomography(found, true, 0)
    off = cv2.perspectiveTransform(found[:, None], same_view)[:, 0] - true
    assert np.linalg.norm(points - true, axis=1).max() > 4, "there is something to take out"
    assert np.linalg.norm(off, axis=1).max() < 0.15


def test_exact_corners_give_the_exact_lens(photographer):
    class Told:
        def find(self, picture):
            row, column = np.divmod(np.arange(54), 9)
            places = np.stack([column * 0.025 - 0.1, row * 0.025 - 0.0625], axis=1)
            seen = photographer.place(places, POSES[int(picture[0, 0])])
            return np.concatenate([places, np.zeros((54, 1))], axis=1).astype(np.float32), seen.astype(
                np.float32
            )

    lens = calibrate_lens([(str(k), np.full(SHAPE, k, np.float32)) for k in range(8)], Told())
    assert np.allclose(lens.camera_matrix, MATRIX, atol=0.02)
    assert np.allclose(lens.distortion, DISTORTION, atol=1e-3)
    assert lens.reprojection_error < 1e-3


def test_there_and_back(true_lens, photographer):
    from .conftest import distort

    y, x = np.mgrid[0:359:7j, 0:479:9j]
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    straight = true_lens.undistorted(points)
    assert np.allclose(true_lens.distorted(straight), points, atol=1e-4)
    rays = (straight - MATRIX[:2, 2]) / np.diag(MATRIX)[:2]
    assert np.allclose(distort(rays), points, atol=1e-4)


def test_undistorted_pictures_show_straight_lines(true_lens, photographer):
    """The board square to the camera: in the undistorted picture each corner is where a pinhole puts it."""
    pose = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.42))
    picture = photographer.picture(paint_chessboard, pose)
    sequence = ImageSequence.from_arrays([picture, picture]).resample(true_lens.undistortion())
    places, corners = CHESSBOARD.find(sequence[0])
    expected = np.diag(MATRIX)[:2] * (places[:, :2] - [0.1, 0.0625]) / 0.42 + MATRIX[:2, 2]
    if np.abs(corners - expected).max() > 5:
        expected = expected[::-1]
    assert np.abs(corners - expected).max() < 0.15
    assert np.abs((corners - expected).mean(axis=0)).max() < 0.03


def test_file(tmp_path, true_lens):
    true_lens.write(tmp_path / "lens.toml")
    lens = Lens.read(tmp_path / "lens.toml")
    assert np.array_equal(lens.camera_matrix, MATRIX)
    assert np.array_equal(lens.distortion, DISTORTION)
    assert lens.shape == SHAPE
    with pytest.raises(CalibrationError, match=r"lens\.toml: exists already"):
        true_lens.write(tmp_path / "lens.toml")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("schema_version = 1", "schema_version = 9", "schema_version 9: this reads 1"),
        ("distortion", "distorsion", "not a lens of this program: 'distortion'"),
        ("520.0", "nan", "must be finite"),
        ("width", "= width", "not a lens of this program"),
    ],
)
def test_bad_files(tmp_path, true_lens, old, new, message):
    path = tmp_path / "lens.toml"
    true_lens.write(path)
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(CalibrationError, match=message):
        Lens.read(path)
    with pytest.raises(CalibrationError, match=r"none\.toml: no such file"):
        Lens.read(tmp_path / "none.toml")


def test_too_few_views_and_other_sizes():
    blank = np.full(SHAPE, 128, np.float32)
    with pytest.raises(CalibrationError, match="the board is seen in 0 of 4 pictures: at least 3"):
        calibrate_lens([(str(k), blank) for k in range(4)], CHESSBOARD)
    with pytest.raises(CalibrationError, match=r"b\.png: 480 x 300 px, but the first picture has 480 x 360"):
        calibrate_lens([("a.png", blank), ("b.png", blank[:300])], CHESSBOARD)


def test_what_moves_as_one_moves_as_one_without_distortion(true_lens, photographer):
    """A flat texture shifted by 2 mm and -1 mm: the same displacement everywhere, as a pinhole sees it."""
    rng = np.random.default_rng(4)
    angle, phase = rng.uniform(0, 2 * np.pi, (2, 60))
    number = 2 * np.pi / rng.uniform(0.006, 0.02, 60)

    def paint(x, y):
        return 128 + sum(
            6 * np.cos(n * (np.cos(a) * x + np.sin(a) * y) + p)
            for n, a, p in zip(number, angle, phase, strict=True)
        )

    pose = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.42))
    pictures = [
        np.clip(photographer.picture(lambda x, y, s=s: paint(x - 0.002 * s, y + 0.001 * s), pose), 0, 255)
        for s in (0, 1)
    ]
    sequence = ImageSequence.from_arrays(pictures)
    expected = np.array([MATRIX[0, 0] * 0.002, -MATRIX[1, 1] * 0.001]) / 0.42
    off = []
    for seen in (sequence, sequence.resample(true_lens.undistortion())):
        flow = analyze(seen, method="farneback", soil="all").isel(pair=0, y=slice(15, -15), x=slice(15, -15))
        off.append(np.hypot(flow["u"] - expected[0], flow["v"] - expected[1]).values)
    assert np.nanpercentile(off[0], 95) > 0.3, "as taken, the edges of the picture move less"
    assert np.nanpercentile(off[1], 95) < 0.06
    assert np.isfinite(off[1]).mean() > 0.9
