"""A clip of footage is footage, and its truth is that of the footage."""

import numpy as np
import pytest

from soft import Region, SequenceError
from synth import Footage
from validation.check import check_folder
from validation.clip import ClipError, clip_footage, parse_frames


@pytest.fixture
def footage(finished_run):
    with Footage.open(finished_run / "footage") as opened:
        yield opened


def test_pictures_and_truth(footage, tmp_path):
    clip_footage(footage, tmp_path / "clip", region=Region(10, 20, 40, 30), first=0, last=1)
    with Footage.open(tmp_path / "clip") as clip:
        np.testing.assert_array_equal(clip.picture(1), footage.picture(1)[20:50, 10:50])
        part, whole = clip.truth(0), footage.truth(0).isel(y=slice(20, 50), x=slice(10, 50))
        np.testing.assert_allclose(part["u"], whole["u"], atol=1.3e-4)
        np.testing.assert_array_equal(part["soil"], whole["soil"])
        assert part["u"].dtype == np.float32 and part["u"].attrs["units"] == "px"
        assert clip.frame_rate == footage.frame_rate


def test_what_leaves_the_window_is_not_valid(footage, tmp_path):
    clip_footage(footage, tmp_path / "clip", region=Region(0, 0, 30, 30), first=0, last=1)
    with Footage.open(tmp_path / "clip") as clip:
        truth = clip.truth(0)
        y, x = np.indices((30, 30))
        inside = (
            ((x + truth["u"]) >= 0)
            & ((x + truth["u"]) <= 29)
            & ((y + truth["v"]) >= 0)
            & ((y + truth["v"]) <= 29)
        )
        assert not (truth["valid"] & ~inside).any()
        assert (~inside).any() and truth["valid"].any()


def test_is_whole(footage, tmp_path):
    clip_footage(footage, tmp_path / "clip", region=Region(10, 20, 40, 30), first=0, last=1)
    findings = check_folder(tmp_path / "clip")
    assert not findings.faults and not findings.remarks


def test_refuses(footage, tmp_path):
    with pytest.raises(ClipError, match="frames 0 to 2"):
        clip_footage(footage, tmp_path / "a", region=Region(0, 0, 10, 10), first=0, last=2)
    with pytest.raises(SequenceError, match="96 x 80 px"):
        clip_footage(footage, tmp_path / "a", region=Region(90, 0, 10, 10), first=0, last=1)
    (tmp_path / "there").mkdir()
    with pytest.raises(ClipError, match="exists"):
        clip_footage(footage, tmp_path / "there", region=Region(0, 0, 10, 10), first=0, last=1)
    with pytest.raises(ClipError, match="FIRST:LAST"):
        parse_frames("3-4")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["there"]


def test_command(softbed, finished_run, tmp_path):
    command = ["clip", finished_run, tmp_path / "clip", "--frames", "0:1"]
    assert softbed(*command, "--crop", "5,5,20,20")[0] == 0
    assert softbed("check", tmp_path / "clip")[0] == 0
    status, _, err = softbed(*command, "--crop", "5,5,20")
    assert status == 2 and "four whole numbers" in err
