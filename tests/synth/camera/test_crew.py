"""Processes that render in turn make the files that one process makes, and end together, whatever happens."""

import errno
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from synth import render
from synth.camera import crew, crew_process
from synth.camera.render import render as photograph
from synth.camera.stages import StageClock
from tests.waiting import PATIENCE, runs, wait_for
from validation.terminal import error_line

FRAMES = 4
STAND_IN = """
import json, sys, time
sys.path[:] = json.loads(sys.argv[1])
from synth.camera import crew_process

class Odd(Exception):
    def __init__(self, frame, word):
        super().__init__(f"frame {frame}")

def take_part(seat, orders, job):
    from synth.camera.placements import Baton
    from synth.camera.rooms import memory_for, rooms_in
    from synth.camera.writing import FootageWriter
    from synth.truth import PairTruth

    writer = FootageWriter(orders, rooms_in(memory_for(job.shape, seat.rooms), job.shape))
    baton = Baton(seat.number, seat.size, seat.heard, seat.told)
    count = job.recording.frame_count
    for frame in range(seat.number, count, seat.size):
        if frame > 0:
            baton.wait()
        if frame + 1 < count:
            baton.pass_on()
        time.sleep(0.02)  # who writes mostly waits for frames
        room = writer.room()
        writer.write_picture(room, frame)
        if frame + 1 < count:
            writer.write_truth(room, PairTruth(frame, frame + 1, {}, {"camera_u": 0.0, "camera_v": 0.0}))
        if count == 13:
            raise Odd(frame, "odd")
    return crew_process.Summary({}, 0.0, 1)

crew_process._take_part = take_part
crew_process.main(*map(int, sys.argv[2:]))
"""
"""Processes with which everything is true but the pictures: they are there in no time."""
LEFT = """
import sys
sys.path.insert(0, {folder!r})
from pathlib import Path
import test_crew
from conftest import _translation, make_case
from synth import render
from synth.camera import crew, crew_process
import synth.camera.render

synth.camera.render._WORTH_A_CREW = 0
crew_process._CODE = test_crew.STAND_IN
start = crew.start_process

def telling(seat):
    process = start(seat)
    print(process.pid, flush=True)
    return process

crew.start_process = telling
case = make_case(_translation(0.1, 0.0), frames=2000)
render(case.recording, case.scene, Path({out!r}), threads=2)
"""


@pytest.fixture
def processes(monkeypatch):
    """Stand-ins, as they are started, however few pictures there are."""
    started, start = [], crew.start_process
    monkeypatch.setattr(crew, "start_process", lambda seat: started.append(start(seat)) or started[-1])
    monkeypatch.setattr(crew_process, "_CODE", STAND_IN)
    monkeypatch.setattr("synth.camera.render._WORTH_A_CREW", 0)
    monkeypatch.setattr(crew, "_LONGEST_FRAME", PATIENCE)  # they end by themselves, however busy the machine
    return started


@pytest.fixture
def still(cases, fields):
    def of(frames):
        case = cases.case(fields["rest"], frames=frames)
        return case.recording, case.scene

    return of


def files_of(folder):
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.usefixtures("rendered_on_one_thread")  # so that not each of them has to compile what it runs
def test_they_make_what_one_process_makes(cases, fields, tmp_path, monkeypatch):
    nuisance = {"exposure": 0.5, "exchange": 0.02, "jitter": 0.1}
    case = cases.case(fields["rotation"](0.02), frames=FRAMES, nuisance=nuisance)
    files, told, clock = [], [], StageClock()

    def progress(*done):
        told.append(done)

    for least in (0, 1e99):
        monkeypatch.setattr("synth.camera.render._WORTH_A_CREW", least)
        folder = tmp_path / str(least)
        photograph(case.recording, case.scene, folder, threads=2, clock=clock, progress=progress).close()
        files.append(files_of(folder))
    assert files[0] == files[1]
    assert len({picture for name, picture in files[0].items() if name.suffix == ".png"}) == FRAMES
    assert told == 2 * [(frame + 1, FRAMES) for frame in range(FRAMES)]
    assert {"strewing", "moving", "covering", "lighting", "truth", "exposing", "writing"} <= set(
        clock.seconds
    )
    assert len(clock.elsewhere) == crew.SIZE
    assert all(one.processor > 0 and one.memory > 2**20 for one in clock.elsewhere)


def test_what_one_of_them_finds_wrong_is_told(still, tmp_path, processes):
    with pytest.raises(RuntimeError, match=r"^Odd: frame 0$") as caught:
        render(*still(13), tmp_path / "f", threads=2)
    assert error_line(caught.value).count("\n") == 0
    assert [process.returncode for process in processes] == [0] * crew.SIZE


def test_an_error_of_the_pictures_travels_as_it_is(cases, fields, tmp_path, monkeypatch):
    monkeypatch.setattr("synth.camera.render._WORTH_A_CREW", 0)
    case = cases.case(fields["rest"], frames=FRAMES)
    case.recording.data["position_x"][:] = 1e3
    with pytest.raises(ValueError, match="soil"):
        render(case.recording, case.scene, tmp_path / "f", threads=2)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device that is always full is needed")
def test_a_full_disk_ends_all_of_them(still, tmp_path, processes, monkeypatch):
    full = Path("/dev/full")
    monkeypatch.setattr("synth.camera.writing_end.write_picture", lambda *_: full.write_bytes(b"."))
    with pytest.raises(OSError) as caught:
        render(*still(40), tmp_path / "f", threads=2)
    assert caught.value.errno == errno.ENOSPC
    assert [process.returncode for process in processes] == [0] * crew.SIZE


@pytest.mark.parametrize("number", range(crew.SIZE))
def test_one_that_is_killed_is_told(still, tmp_path, processes, number):
    def kill(done, _):
        if done == 3:
            processes[number].kill()

    with pytest.raises(crew.RenderingError, match="has ended, with status -9") as caught:
        render(*still(2000), tmp_path / "f", threads=2, progress=kill)
    assert error_line(caught.value).count("\n") == 0
    assert sorted(process.returncode for process in processes) == [-9, 0]


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="processes are looked for in /proc")
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
def test_they_end_with_who_started_them(tmp_path, request, how):
    script = LEFT.format(folder=str(request.path.parent), out=str(tmp_path / "f"))
    with subprocess.Popen(
        [sys.executable, "-c", script],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        # A shell's background jobs ignore interrupts, and hand that down.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    ) as parent:
        left = [int(parent.stdout.readline()) for _ in range(crew.SIZE)]
        wait_for(lambda: (tmp_path / "f" / "frames" / "000002.png").is_file())
        parent.send_signal(how)
    assert parent.returncode != 0
    wait_for(lambda: not any(map(runs, left)))
