"""`softbed analyze` and `softbed calibrate-camera` on pictures of one's own."""

import json
import re
import shutil
import subprocess
import sys
import time

import cv2
import numpy as np
import pytest
import xarray as xr

from soft import read_flo, read_soil_flow

SHAPE = (96, 128)


def soil(frame, shape=SHAPE):
    """Grains that go 1.5 px to the left and 0.5 px down a frame, whose grey levels are a formula."""
    rng = np.random.default_rng(3)
    angle, phase = rng.uniform(0, 2 * np.pi, (2, 120))
    number = 2 * np.pi / rng.uniform(5, 20, 120)
    y, x = np.mgrid[: shape[0], : shape[1]].astype(float)
    x, y = x + 1.5 * frame, y - 0.5 * frame
    waves = np.cos(
        number[:, None, None] * (np.cos(angle)[:, None, None] * x + np.sin(angle)[:, None, None] * y)
        + phase[:, None, None]
    )
    return np.clip(np.rint(128 + 5 * waves.sum(axis=0)), 0, 255).astype(np.uint8)


@pytest.fixture
def photographs(tmp_path, monkeypatch):
    """A folder `rig` of seven pictures in the current folder."""
    folder = tmp_path / "rig"
    folder.mkdir()
    for k in range(7):
        cv2.imwrite(str(folder / f"shot{k}.png"), soil(k))
    monkeypatch.chdir(tmp_path)
    return folder


def measured(folder, method="farneback"):
    return read_soil_flow(folder / "analysis" / f"{method}.nc")


def test_vertical_motion_that_is_left_in_is_told(softbed, photographs):
    arguments = ["analyze", photographs, "--soil", "all", "--method", "farneback"]
    told = "most soil moves 0.5 px down a pair, which is left in"
    assert told in softbed(*arguments)[2]
    assert told not in softbed(*arguments, "--vertical")[2]


def test_a_camera_that_seems_unsteady_is_told(softbed, photographs):
    arguments = ["analyze", photographs, "--soil", "all", "--method", "farneback"]
    told = "changes much from pair to pair"
    assert told not in softbed(*arguments)[2]
    for k in range(3, 7):
        cv2.imwrite(str(photographs / f"shot{k}.png"), soil(2 * k))
    assert told in softbed(*arguments)[2]


def test_processes_share_the_pairs(softbed, photographs):
    results = []
    for count in (1, 2):
        out = photographs.parent / str(count)
        arguments = ["analyze", photographs, "--out", out, "--soil", "all", "--method", "farneback"]
        status, _, error = softbed(*arguments, "--processes", count)
        assert status == 0, error
        results.append(measured(out).load())
    xr.testing.assert_equal(*results)


def test_settings_from_a_file_and_options_before_them(softbed, photographs):
    file = photographs.parent / "settings.toml"
    assert softbed("analyze", "--write-settings", file)[0] == 0
    text = file.read_text().replace('kind = "bright"', 'kind = "all"').replace("stride = 1", "stride = 3")
    text = text.replace('method = "robust-affine"', 'method = "farneback"')
    text = text.replace("options = {}", "options = { window_size = 21 }").replace(
        "vertical = false", "vertical = true"
    )
    file.write_text(text.replace("# metres_per_pixel = 0.0002", "metres_per_pixel = 0.0002"))
    arguments = ["analyze", photographs, "--settings", file, "--stride", 2, "--frame-rate", 8]
    status, _, error = softbed(*arguments, "--start", 1, "--every", 2)
    assert status == 0, error
    with measured(photographs.parent / "rig-softbed") as flow:
        assert flow["first_frame"].values.tolist() == [1, 3]
        assert flow["second_frame"].values.tolist() == [3, 5]
        assert flow["time"].values.tolist() == [0.125, 0.375]
        assert flow["camera_u"].values == pytest.approx([-3, -3], abs=0.05)
        assert flow["camera_v"].values == pytest.approx([1, 1], abs=0.05)
        assert json.loads(flow.attrs["options"])["window_size"] == 21
        assert flow.attrs["metres_per_pixel"] == 2e-4
    assert re.search(r"camera: resting soil -(3\.0|2\.9)\d+ ± 0\.0", error)
    assert "camera 0.24" in error
    assert "px of 0.0002 m: " in error and "warning" not in error
    # The same again is skipped; other pairs are not.
    assert "skipped" in softbed(*arguments, "--start", 1, "--every", 2)[2]
    assert "what it depends on has changed" in softbed(*arguments, "--start", 2, "--every", 2)[2]


def test_a_pixel_size_in_another_unit_is_warned_of(softbed, photographs):
    arguments = ["--method", "farneback", "--soil", "all", "--stop", 2]
    status, _, error = softbed("analyze", photographs, *arguments, "--metres-per-pixel", 0.2)
    assert status == 0
    assert f"px of 0.2 m: {0.2 * SHAPE[1]:.3g} m wide: is the pixel size in metres?" in error


def test_pictures_of_the_same_name_elsewhere_replace_nothing(softbed, photographs):
    arguments = ["--method", "farneback", "--soil", "all", "--stop", 2]
    assert softbed("analyze", photographs, *arguments)[0] == 0
    before = (photographs.parent / "rig-softbed" / "analysis" / "farneback.nc").read_bytes()
    other = photographs.parent / "second" / "rig"
    other.mkdir(parents=True)
    for k in range(2):
        cv2.imwrite(str(other / f"shot{k}.png"), soil(2 * k))
    status, _, error = softbed("analyze", other, *arguments)
    assert status == 2
    assert f"rig-softbed: holds what was measured in {photographs}: nothing is replaced, choose" in error
    # Nor are figures drawn of the one on the pictures of the other.
    for k in range(2, 7):
        cv2.imwrite(str(other / f"shot{k}.png"), soil(2 * k))
    status, _, error = softbed("figure", "speed", other, "--out", "speed.png")
    assert status == 2 and "farneback.nc: not of the pictures in" in error
    assert (photographs.parent / "rig-softbed" / "analysis" / "farneback.nc").read_bytes() == before
    # The same pictures may have moved, and a picture may have been mended where it lies.
    moved = photographs.rename(photographs.parent / "second" / "moved").rename(photographs)
    assert softbed("analyze", moved, *arguments)[0] == 0
    cv2.imwrite(str(photographs / "shot1.png"), soil(2))
    assert softbed("analyze", photographs, *arguments)[0] == 0


def test_region_and_masks(softbed, photographs):
    mask = np.zeros(SHAPE, np.uint8)
    mask[:, 64:] = 255
    cv2.imwrite(str(photographs.parent / "mask.png"), mask)
    status, _, error = softbed(
        "analyze", photographs, "--method", "farneback", "--soil", "all", "--region", "40,10,60,70",
        "--masks", "mask.png", "--stop", 2,
    )  # fmt: skip
    assert status == 0, error
    with measured(photographs.parent / "rig-softbed") as flow:
        assert (flow.sizes["pair"], flow.sizes["y"], flow.sizes["x"]) == (1, 70, 60)
        assert (flow.attrs["region_x"], flow.attrs["region_y"]) == (40, 10)
        assert np.array_equal(flow["soil"].values[0], mask[10:80, 40:100] > 0)
    # What is exported are the pictures as they were analyzed.
    status, _, error = softbed("export", photographs, "--format", "flo")
    assert status == 0, error
    found = list((photographs.parent / "rig-softbed" / "flo").rglob("*.flo"))
    assert [read_flo(path).shape for path in found] == [(70, 60, 2)]
    # Results are not pictures: what they are an option of is told.
    for command in (
        ("export", "rig-softbed", "--format", "flo"),
        ("figure", "speed", "rig-softbed", "--out", "speed.png"),
    ):
        status, _, error = softbed(*command)
        assert status == 2
        assert "--results (figure) or --out" in error


def write_film(path, codec, frame_count):
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*codec), 25.0, SHAPE[::-1])
    for k in range(frame_count):
        writer.write(cv2.cvtColor(soil(k), cv2.COLOR_GRAY2BGR))
    writer.release()


def test_video(softbed, photographs):
    film = photographs.parent / "rig.mkv"
    write_film(film, "FFV1", 5)
    before = film.read_bytes()
    status, _, error = softbed("analyze", film, "--method", "farneback", "--soil", "all", "--stride", 2)
    assert status == 0, error
    with measured(photographs.parent / "rig-softbed") as flow:
        assert flow["camera_u"].values == pytest.approx([-3, -3, -3], abs=0.05)
        assert flow.attrs["frame_rate"] == pytest.approx(25)
    assert film.read_bytes() == before
    figures = photographs.parent / "rig-softbed" / "figures" / "farneback"
    assert list(figures.glob("*.png"))
    assert (figures / "interface-0001.csv").read_text() == "line,x_px,y_px\n", "nothing moves in the soil"
    assert "pair 1: no moving region" in error
    agreement = re.search(r"SIFT on pair 1: .*flow agrees with ([\d.]+)% within 0.56 px", error)
    assert float(agreement[1]) > 90


def test_video_cut_short(softbed, photographs):
    film = photographs.parent / "rig.avi"
    write_film(film, "MJPG", 12)
    film.write_bytes(film.read_bytes()[: film.stat().st_size // 2])
    status, _, error = softbed("analyze", film, "--method", "dis", "--soil", "all")
    assert status == 0, error
    told = re.search(r"warning: rig\.avi: (\d) of the 12 frames that it tells of could be decoded", error)
    with measured(photographs.parent / "rig-softbed", "dis") as flow:
        assert flow.sizes["pair"] == int(told[1]) - 1
        assert told[0].removeprefix("warning: ") in flow.attrs["remarks"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["rig", "--region", "1,2,3"], ["--region '1,2,3'", "four whole numbers"]),
        (["rig", "--region", "100,0,64,64"], ["region 100,0,64,64", "128 x 96 px"]),
        (["rig", "--stride", "7"], ["no pair in 7 frames"]),
        (["rig", "--every", "0"], ["options: frames.every"]),
        (["rig", "--masks", "none.png"], ["masks none.png", "neither a picture nor a folder"]),
        (["rig", "--lens", "none.toml"], ["lens none.toml: no such file"]),
        (["rig", "--settings", "none.toml"], ["none.toml: no such file"]),
        (["--stride", "2"], ["PATH is missing"]),
    ],
)
def test_what_is_refused(softbed, photographs, arguments, words):
    status, output, error = softbed("analyze", *arguments)
    assert (status, output) == (2, "")
    assert error.count("\n") == 1
    for word in words:
        assert word in error
    assert not (photographs.parent / "rig-softbed").exists()


def test_killed_it_goes_on_and_ends_with_the_same_values(softbed, photographs, tmp_path):
    for k in range(7):
        cv2.imwrite(str(photographs / f"shot{k}.png"), soil(k, (240, 320)))
    command = ["analyze", str(photographs), "--soil", "all", "--out"]
    run = [sys.executable, "-c", "from validation.cli import main; main()", *command, "killed"]
    process = subprocess.Popen(run, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    kept = tmp_path / "killed" / ".analysis-robust-affine"
    while len(list(kept.glob("*.npz"))) < 2 and process.poll() is None:
        time.sleep(0.02)
    process.kill()
    assert process.wait() != 0, "killed before it was done"
    assert not (tmp_path / "killed" / "analysis").exists()
    status, _, error = softbed(*command, "killed")
    assert status == 0, error
    assert "was stopped: flow of" in error
    assert not kept.exists()
    assert softbed(*command, "whole")[0] == 0
    with (
        measured(tmp_path / "killed", "robust-affine") as killed,
        measured(tmp_path / "whole", "robust-affine") as whole,
    ):
        xr.testing.assert_equal(killed, whole)


def test_camera_is_calibrated_from_photographs_of_a_board(softbed, tmp_path):
    """Boards warped without distortion: the lens found has hardly any, and pictures stay as they are."""
    boards = tmp_path / "boards"
    boards.mkdir()
    _photograph_boards(boards)
    lens = tmp_path / "lens.toml"
    arguments = ["calibrate-camera", boards, "--board", "chessboard:8x5:0.02", "--output", lens]
    status, output, error = softbed(*arguments, "--json")
    assert status == 0, error
    told = json.loads(output)
    assert told["unseen"] == ["none.png"]
    assert told["reprojection_error"] < 0.15
    assert np.abs(told["distortion"][:2]).max() < 0.02
    status, _, error = softbed(*arguments)
    assert status == 2
    assert "exists already" in error
    shutil.rmtree(boards)
    pictures = tmp_path / "pictures"
    pictures.mkdir()
    for k in range(2):
        cv2.imwrite(str(pictures / f"{k}.png"), soil(k, (360, 480)))
    out = tmp_path / "out"
    status, _, error = softbed(
        "analyze", pictures, "--lens", lens, "--method", "farneback", "--soil", "all", "--out", out
    )
    assert status == 0, error
    with measured(out) as flow:
        assert flow["camera_u"].values == pytest.approx([-1.5], abs=0.05)
        assert "lens taken out" in flow.attrs["calibration"]


def _photograph_boards(folder):
    """Five views by a pinhole camera of 500 px focal length; and a picture of nothing."""
    square = 60
    row, column = np.indices((6 * square, 9 * square)) // square
    board = np.pad(np.where((row + column) % 2, 220, 30).astype(np.float32), square, constant_values=220)
    board = cv2.GaussianBlur(board, (0, 0), 3)
    matrix = np.array([[500.0, 0, 239.5], [0, 500, 179.5], [0, 0, 1]])
    to_metres = np.array([[0.02 / square, 0, -0.11], [0, 0.02 / square, -0.08], [0, 0, 1]])
    to_metres[:2, 2] += 0.5 * 0.02 / square  # pixel centres of the print are whole numbers
    for k, turn in enumerate([(0, 0, 0), (0.5, 0, 0), (0, 0.5, 0), (-0.4, 0.3, 0.2), (0.2, -0.5, 0)]):
        rotation = cv2.Rodrigues(np.array(turn, float))[0]
        place = np.column_stack([rotation[:, 0], rotation[:, 1], [0.01 * (k - 2), 0, 0.32]])
        view = cv2.warpPerspective(
            board, matrix @ place @ to_metres, (480, 360), flags=cv2.INTER_AREA, borderValue=220
        )
        cv2.imwrite(str(folder / f"{k}.png"), view)
    cv2.imwrite(str(folder / "none.png"), np.full((360, 480), 128, np.uint8))
