"""What is left to do of a frame is done beside, while the next one is rendered: noise, compression, files.

Where there is much of it a process of its own does it: taichi's kernels hold Python's global lock, and a
thread would wait for them. Both do the same, so the files are the same.
"""

import os
import subprocess
import threading
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from types import TracebackType
from typing import TYPE_CHECKING, Self

from synth.camera.rooms import Room, bytes_needed, memory_for, rooms_in
from synth.camera.stages import StageClock
from synth.camera.writing_end import Done, Footing, Freed, Order, WritePicture, WriteTruth, carry_out
from synth.camera.writing_process import start_process

if TYPE_CHECKING:
    from synth.truth import PairTruth

_LONGEST_ORDER = 30.0
"""Seconds that a process may go on with what it is at, where nobody wants the rest."""


class WritingError(RuntimeError):
    """The process that writes ended without a word."""


class FootageWriter:
    """Writes pictures and truth in the order they come, from rooms that are used again and again.

    An error in writing comes up at the next call, or at the end.

    Parameters
    ----------
    footing : Footing
    apart : bool
        In a process of its own, which costs half a second of a core to start; otherwise in a thread.
    clock : StageClock, optional
        Adds up how long each stage takes, once all is written.
    """

    def __init__(self, footing: Footing, *, apart: bool, clock: StageClock | None = None) -> None:
        self._clock = clock or StageClock()
        self._orders, theirs = Pipe()
        self._process: subprocess.Popen[bytes] | None = None
        self._thread: threading.Thread | None = None
        if apart:
            rooms = self._start_process(footing, theirs)
        else:
            rooms = rooms_in(memory_for(footing.shape), footing.shape)
            self._thread = threading.Thread(target=carry_out, args=(theirs, footing, rooms), daemon=True)
            self._thread.start()
        self._rooms, self._free = tuple(rooms), list(rooms)

    def _start_process(self, footing: Footing, theirs: Connection) -> list[Room]:
        memory = os.memfd_create("footage")
        try:
            os.truncate(memory, bytes_needed(footing.shape))
            rooms = rooms_in(memory_for(footing.shape, memory), footing.shape)
            self._process = start_process(theirs, memory)
        finally:
            os.close(memory)
            theirs.close()
        self._orders.send(footing)
        return rooms

    def room(self) -> Room:
        """Wait for a room that the next frame can be put in."""
        while not self._free or self._orders.poll():
            self._hear()
        return self._free.pop()

    def write_picture(self, room: Room, frame: int) -> None:
        """Write the light in a room as a frame's picture."""
        self._tell(WritePicture(room.number, frame))

    def write_truth(self, room: Room, pair: "PairTruth") -> None:
        """Write the truth of a pair, which lies in a room; the room is given back."""
        self._tell(WriteTruth(room.number, pair.first, pair.second, pair.camera))

    def _tell(self, order: Order | None) -> None:
        try:
            self._orders.send(order)
        except OSError:
            while True:  # why nobody listens is the last that was said
                self._hear()

    def _hear(self) -> Done | None:
        try:
            answer = self._orders.recv()
        except (EOFError, OSError):
            raise WritingError(f"footage: the process that writes it has ended{self._how()}") from None
        if isinstance(answer, BaseException):
            raise answer
        if isinstance(answer, Freed):
            self._free.append(self._rooms[answer.room])
            return None
        return answer

    def _how(self) -> str:
        status = None if self._process is None else self._process.wait()
        return "" if status is None else f", with status {status}"

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        try:
            if kind is None:
                self._finish()
        finally:
            self._orders.close()
            self._wait_for_end()

    def _finish(self) -> None:
        self._tell(None)
        while (done := self._hear()) is None:
            pass
        for stage, seconds in done.seconds.items():
            self._clock.seconds[stage] += seconds
        if self._process is not None:
            self._clock.processor_elsewhere += done.processor
            self._clock.memory_elsewhere = max(self._clock.memory_elsewhere, done.peak_memory)

    def _wait_for_end(self) -> None:
        if self._thread is not None:
            self._thread.join()
        if self._process is not None:
            try:
                self._process.wait(_LONGEST_ORDER)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
