"""A process that renders some of the frames. It ends with the one that started it, however that ends."""

import contextlib
import json
import pickle
import subprocess
import sys
import time
import traceback
from dataclasses import astuple, dataclass
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from synth.recording import Recording
    from synth.scene import Scene

# It takes the modules from where its parent has them, and needs no guard in the parent's main module.
_CODE = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from synth.camera.crew_process import main; main(*map(int, sys.argv[2:]))"
)


@dataclass(frozen=True)
class Seat:
    """A process's place among those that take turns: its number, their count, and file descriptors.

    Attributes
    ----------
    number, size : int
    orders : int
        Connection to who writes.
    rooms : int
        Memory of `synth.camera.rooms`.
    grains : int
        Memory that all of them share, of `synth.camera.placements`.
    heard, told : int
        See `synth.camera.placements.Baton`.
    """

    number: int
    size: int
    orders: int
    rooms: int
    grains: int
    heard: int
    told: int


@dataclass(frozen=True)
class Job:
    """The first that a process hears."""

    recording: "Recording"
    scene: "Scene"
    shape: tuple[int, int]
    threads: int


@dataclass(frozen=True)
class Summary:
    """The last that a process says.

    Attributes
    ----------
    seconds : dict
        By stage, for its frames after the first.
    processor : float
        Seconds of the processor a frame, likewise.
    memory : int
        Bytes that it holds in the end, when all its buffers are there: see `synth.memory`.
    """

    seconds: dict[str, float]
    processor: float
    memory: int


def start_process(seat: Seat) -> "subprocess.Popen[bytes]":
    """Start a process; what it gets first must be its `Job`."""
    numbers = astuple(seat)
    return subprocess.Popen(
        [sys.executable, "-c", _CODE, json.dumps(sys.path), *map(str, numbers)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        pass_fds=numbers[2:],
        process_group=0,  # an interrupt is for the parent, which tells when it is over
    )


def main(*numbers: int) -> None:
    """What the process does."""
    seat = Seat(*numbers)
    orders = Connection(seat.orders)
    with contextlib.suppress(EOFError, ConnectionError):  # nobody wants it any more
        try:
            last_word: Summary | BaseException = _take_part(seat, orders, orders.recv())
        except (EOFError, ConnectionError):
            raise
        except BaseException as error:
            last_word = _that_travels(error)
        orders.send(last_word)
        while True:  # what is not read when a connection is closed can cost the other side the last word
            orders.recv()


def _take_part(seat: Seat, orders: Connection, job: Job) -> Summary:
    from synth.camera.frames import make_frames
    from synth.camera.nuisance import as_seen
    from synth.camera.placements import Baton, own_steps
    from synth.camera.rooms import memory_for, rooms_in
    from synth.camera.stages import StageClock
    from synth.camera.writing import FootageWriter
    from synth.devices import start_taichi
    from synth.memory import memory_share

    start_taichi(threads=job.threads)
    clock, recording = StageClock(), as_seen(job.recording, job.scene)
    baton = Baton(seat.number, seat.size, seat.heard, seat.told)
    used: list[float] = []

    def frame_done(_: int) -> None:
        used.append(time.process_time())
        if len(used) == 1:
            clock.seconds.clear()  # kernels were loaded

    make_frames(
        recording,
        job.scene,
        FootageWriter(orders, rooms_in(memory_for(job.shape, seat.rooms), job.shape)),
        clock,
        lambda motion: own_steps(motion, recording.frame_count, clock, baton, seat.grains),
        frame_done,
    )
    per_frame = (used[-1] - used[0]) / max(len(used) - 1, 1)
    return Summary(dict(clock.seconds), per_frame, memory_share())


def _that_travels(error: BaseException) -> BaseException:
    """An error as it can be sent, with the place it comes from."""
    error.add_note("".join(traceback.format_exception(error)))
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error
