"""Several processes that render a recording's frames in turn; what they make is written here, in order.

Part of a frame's work runs on one thread, and taichi's kernels hold Python's global lock: two processes with
a thread each make more pictures than one process with two.
"""

import contextlib
import itertools
import os
import subprocess
from collections.abc import Iterator, Sequence
from multiprocessing import Pipe
from typing import TYPE_CHECKING

from synth.camera.crew_process import Job, Seat, Summary, start_process
from synth.camera.rooms import bytes_needed, memory_for, rooms_in
from synth.camera.writing_end import End, carry_out

if TYPE_CHECKING:
    from collections.abc import Callable

    from synth.camera.stages import StageClock
    from synth.camera.writing_end import Footing
    from synth.recording import Recording

SIZE = 2
"""Processes. Each needs some 0.5 GiB of its own for pictures of 1200 x 600 px."""
_LONGEST_FRAME = 30.0
"""Seconds that a process may go on with what it is at, where nobody wants the rest."""


class RenderingError(RuntimeError):
    """A process that renders ended without a word."""


def render_in_turn(
    footing: "Footing",
    recording: "Recording",
    *,
    threads: int,
    clock: "StageClock",
    progress: "Callable[[int, int], None] | None",
) -> None:
    """Render and write all frames.

    Parameters
    ----------
    threads : int
        Of all processes together.
    """
    with _crew(footing, recording, max(threads // SIZE, 1)) as (ends, processes):
        try:
            carry_out(ends, footing, clock, progress)
            for end in ends:
                clock.add(_summary(end))
        except (EOFError, ConnectionError):
            raise RenderingError(f"footage: {_how_it_ended(processes)}") from None


def _summary(end: End) -> Summary:
    said = end.orders.recv()
    if isinstance(said, BaseException):
        raise said
    assert isinstance(said, Summary)
    return said


@contextlib.contextmanager
def _crew(
    footing: "Footing", recording: "Recording", threads: int
) -> "Iterator[tuple[list[End], list[subprocess.Popen[bytes]]]]":
    """Processes, and from where their orders to write come; they end with this context."""
    ends: list[End] = []
    processes: list[subprocess.Popen[bytes]] = []
    try:
        with contextlib.ExitStack() as handed_on:
            grains = _memory("grains", handed_on)
            # What the n-th hears is told by the one before it.
            batons = [os.pipe() for _ in range(SIZE)]
            for descriptor in itertools.chain(*batons):
                handed_on.callback(os.close, descriptor)
            for number, (heard, _) in enumerate(batons):
                orders, theirs = Pipe()
                handed_on.callback(theirs.close)
                rooms = _memory("rooms", handed_on)
                os.truncate(rooms, bytes_needed(footing.shape))
                ends.append(End(orders, rooms_in(memory_for(footing.shape, rooms), footing.shape)))
                _, told = batons[(number + 1) % SIZE]
                seat = Seat(number, SIZE, theirs.fileno(), rooms, grains, heard, told)
                processes.append(start_process(seat))
        for end in ends:
            with contextlib.suppress(OSError):  # why it does not listen comes up when it is to be heard
                end.orders.send(Job(recording, footing.scene, footing.shape, threads))
        yield ends, processes
    finally:
        for end in ends:
            end.orders.close()
        _wait_for(processes)


def _memory(name: str, handed_on: contextlib.ExitStack) -> int:
    descriptor = os.memfd_create(name)
    handed_on.callback(os.close, descriptor)
    return descriptor


def _how_it_ended(processes: "Sequence[subprocess.Popen[bytes]]") -> str:
    """What is known of the process that ended first: the others have ended because of it, with status 0."""
    states = [process.wait(_LONGEST_FRAME) for process in processes]
    return f"a process that renders it has ended, with status {next(filter(None, states), 0)}"


def _wait_for(processes: "Sequence[subprocess.Popen[bytes]]") -> None:
    for process in processes:
        try:
            process.wait(_LONGEST_FRAME)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
