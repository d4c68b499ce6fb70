"""Frames are written beside, by a thread or by a process: the same files, and no word of trouble is lost."""

import errno
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from synth import render
from synth.camera.stages import StageClock
from synth.camera.writing import FootageWriter, WritingError
from synth.camera.writing_end import Footing
from synth.truth import PairTruth
from validation.terminal import error_line

FRAMES, SHAPE = 5, (40, 60)
CAMERA = {"camera_u": 1.5, "camera_v": -2.0}
KILLED = """
import sys, time
sys.path.insert(0, {folder!r})
from conftest import make_scene
from pathlib import Path
import numpy as np
from synth.camera.writing import FootageWriter
from synth.camera.writing_end import Footing
with FootageWriter(Footing(Path({out!r}), make_scene(), np.arange(3.0), (96, 128)), apart=True) as writer:
    print(writer._process.pid, flush=True)
    writer.write_picture(writer.room(), 0)
    time.sleep(60)
"""


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


def files_of(folder):
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_a_process_writes_what_a_thread_writes(footing):
    clocks, files = {}, {}
    for apart in (False, True):
        place, clocks[apart] = footing(str(apart)), StageClock()
        with FootageWriter(place, apart=apart, clock=clocks[apart]) as writer:
            write_all(writer)
        files[apart] = files_of(place.folder)
        assert set(clocks[apart].seconds) == {"exposing", "writing"}
    assert len(files[True]) == FRAMES + 1
    assert files[True] == files[False]
    assert clocks[False].processor_elsewhere == 0.0 < clocks[True].processor_elsewhere
    assert clocks[True].memory_elsewhere > 2**20


def test_footage_of_a_process_is_that_of_a_thread(cases, fields, tmp_path, monkeypatch):
    case, files = cases.case(fields["rotation"](0.02), frames=5), []
    for apart in (False, True):
        monkeypatch.setattr("synth.camera.render._write_apart", lambda *_, apart=apart: apart)
        render(case.recording, case.scene, tmp_path / str(apart)).close()
        files.append(files_of(tmp_path / str(apart)))
    assert files[0] == files[1]
    assert len({picture for name, picture in files[0].items() if name.suffix == ".png"}) == 5


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device that is always full is needed")
@pytest.mark.parametrize("apart", [False, True])
def test_a_full_disk_is_told_in_one_line_with_the_file(footing, apart):
    place = footing("full")
    picture = place.folder / "frames" / "000001.png"
    picture.symlink_to("/dev/full")
    with pytest.raises(OSError) as caught, FootageWriter(place, apart=apart) as writer:
        write_all(writer)
    assert caught.value.errno == errno.ENOSPC
    assert error_line(caught.value).count("\n") == 0
    assert "No space left on device" in error_line(caught.value)
    assert str(picture) in error_line(caught.value)


@pytest.mark.parametrize("apart", [False, True])
def test_a_truth_that_cannot_be_written_is_told_before_a_frame_is_made(footing, apart):
    place = footing("damaged")
    (place.folder / "truth.nc").mkdir()
    with pytest.raises(OSError, match=r"truth\.nc"), FootageWriter(place, apart=apart) as writer:
        write_all(writer)


def test_a_writer_that_was_killed_is_told(footing):
    with (
        pytest.raises(WritingError, match="the process that writes it has ended, with status -9") as caught,
        FootageWriter(footing("killed"), apart=True) as writer,
    ):
        writer.room()
        writer._process.kill()
        write_all(writer)
    assert error_line(caught.value).count("\n") == 0


@pytest.mark.parametrize("apart", [False, True])
def test_an_interrupt_of_who_makes_frames_ends_who_writes_them(footing, apart):
    place = footing("interrupted")
    with pytest.raises(KeyboardInterrupt), FootageWriter(place, apart=apart) as writer:
        writer.write_picture(writer.room(), 0)
        raise KeyboardInterrupt
    if apart:
        assert writer._process.returncode == 0
    else:
        assert not writer._thread.is_alive()


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="processes are looked for in /proc")
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
def test_a_writer_ends_with_who_started_it(tmp_path, request, how):
    (tmp_path / "frames").mkdir()
    script = KILLED.format(folder=str(request.path.parent), out=str(tmp_path))
    with subprocess.Popen(
        [sys.executable, "-c", script],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        # A shell's background jobs ignore interrupts, and hand that down.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    ) as parent:
        writer = int(parent.stdout.readline())
        parent.send_signal(how)
    assert parent.returncode != 0
    for _ in range(100):
        if not Path(f"/proc/{writer}").exists() or "Z" in Path(f"/proc/{writer}/stat").read_text().split()[2]:
            return
        time.sleep(0.1)
    pytest.fail("the process goes on")
