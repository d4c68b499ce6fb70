"""Frames are written beside, while the next ones are made, and no word of trouble is lost."""

import errno
import threading
from pathlib import Path

import numpy as np
import pytest

from synth.camera.stages import StageClock
from synth.camera.writing import writing_beside
from synth.camera.writing_end import Footing
from synth.truth import PairTruth
from validation.terminal import error_line

FRAMES, SHAPE = 5, (40, 60)
CAMERA = {"camera_u": 1.5, "camera_v": -2.0}


@pytest.fixture
def footing(cases, tmp_path):
    def of(name):
        folder = tmp_path / name
        (folder / "frames").mkdir(parents=True)
        return Footing(folder, cases.scene(), np.arange(FRAMES) * 0.5, SHAPE)

    return of


def write_all(writer):
    for frame in range(FRAMES):
        room, generator = writer.room(), np.random.default_rng(frame)
        room.light[:] = generator.random(SHAPE)
        for values in room.truth.values():
            values[:] = 3 * generator.random(SHAPE)
        writer.write_picture(room, frame)
        if frame + 1 < FRAMES:
            writer.write_truth(room, PairTruth(frame, frame + 1, room.truth, CAMERA))


def test_everything_is_written_when_the_context_ends(footing):
    place, clock = footing("whole"), StageClock()
    with writing_beside(place, clock) as writer:
        write_all(writer)
    assert len([path for path in place.folder.rglob("*") if path.is_file()]) == FRAMES + 1
    assert set(clock.seconds) == {"exposing", "writing"}


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device that is always full is needed")
def test_a_full_disk_is_told_in_one_line_with_the_file(footing):
    place = footing("full")
    picture = place.folder / "frames" / "000001.png"
    picture.symlink_to("/dev/full")
    with pytest.raises(OSError) as caught, writing_beside(place, StageClock()) as writer:
        write_all(writer)
    assert caught.value.errno == errno.ENOSPC
    assert error_line(caught.value).count("\n") == 0
    assert "No space left on device" in error_line(caught.value)
    assert str(picture) in error_line(caught.value)


def test_a_truth_that_cannot_be_written_is_told_before_a_frame_is_made(footing):
    place = footing("damaged")
    (place.folder / "truth.nc").mkdir()
    with pytest.raises(OSError, match=r"truth\.nc"), writing_beside(place, StageClock()) as writer:
        write_all(writer)


def test_an_interrupt_of_who_makes_frames_ends_who_writes_them(footing):
    place = footing("interrupted")
    with pytest.raises(KeyboardInterrupt), writing_beside(place, StageClock()) as writer:
        writer.write_picture(writer.room(), 0)
        raise KeyboardInterrupt
    assert "footage" not in {thread.name for thread in threading.enumerate()}
