import shutil

import cv2
import numpy as np
import pytest

from synth import Footage, render


@pytest.fixture(scope="module")
def master(cases, tmp_path_factory):
    folder = tmp_path_factory.mktemp("master") / "footage"
    case = cases.plate([0.0, 0.02])
    render(case.recording, case.scene, folder).close()
    return folder


@pytest.fixture
def folder(master, tmp_path):
    return shutil.copytree(master, tmp_path / "footage")


def refuse(folder, pattern):
    with pytest.raises(ValueError, match=pattern) as caught:
        Footage.open(folder).picture(1)
    assert "\n" not in str(caught.value)


def edit(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def test_whole_footage_opens(folder, cases):
    with Footage.open(folder) as footage:
        assert footage.picture(1).shape == cases.size
        assert footage.truth(0).u.shape == cases.size
        assert footage.attributes["scene"] == "plate_rotation"


def test_a_missing_picture_is_named(folder):
    (folder / "frames/000001.png").unlink()
    refuse(folder, r"000001\.png: named in sequence\.toml, but there is no such file")


def test_an_unreadable_picture_is_named(folder):
    (folder / "frames/000001.png").write_bytes(b"nothing")
    refuse(folder, r"000001\.png: not readable as a picture")


def test_a_picture_of_another_size_is_named(folder):
    cv2.imwrite(str(folder / "frames/000001.png"), np.zeros((7, 9), np.uint8))
    refuse(folder, r"000001\.png: 9 x 7 px: truth\.nc has 128 x 96")


def test_a_coloured_picture_is_named(folder):
    cv2.imwrite(str(folder / "frames/000001.png"), np.zeros((96, 128, 3), np.uint8))
    refuse(folder, "a grey picture")


@pytest.mark.parametrize("name", ["sequence.toml", "truth.nc"])
def test_a_missing_file_is_named(folder, name):
    (folder / name).unlink()
    refuse(folder, f"{name}: [Nn]o such file")


def test_a_truncated_truth_is_named(folder):
    path = folder / "truth.nc"
    path.write_bytes(path.read_bytes()[:2000])
    refuse(folder, r"truth\.nc: not readable as netCDF-4")


def test_a_truth_of_another_length_is_named(folder):
    sequence = folder / "sequence.toml"
    edit(sequence, '    "frames/000001.png",\n', '    "frames/000001.png",\n    "frames/000001.png",\n')
    refuse(folder, r"truth\.nc: 1 pairs for 3 pictures: 2 are needed")


@pytest.mark.parametrize(
    ("old", "new", "pattern"),
    [
        ("schema_version = 1", "schema_version = 7", "schema_version = 7: this program reads 1"),
        ("frame_rate = 1.0", "frame_rate = -1.0", "frame_rate = -1.0: a positive number"),
        ("frame_rate", "frame_rates", "keys missing or unknown: frame_rate, frame_rates"),
        ("frame_rate", "= ", "not TOML"),
    ],
)
def test_a_wrong_key_is_named(folder, old, new, pattern):
    edit(folder / "sequence.toml", old, new)
    refuse(folder, pattern)


def test_frames_and_pairs_out_of_range_are_refused(folder):
    with Footage.open(folder) as footage:
        with pytest.raises(ValueError, match="frame = 2: allowed are 0 to 1"):
            footage.picture(2)
        with pytest.raises(ValueError, match="pair = 1: allowed are 0 to 0"):
            footage.truth(1)
