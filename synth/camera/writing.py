"""Who renders hands on what is left to do of a frame, and goes on with the next one."""

import contextlib
import threading
from collections.abc import Iterator
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING

from synth.camera.rooms import Room, memory_for, rooms_in
from synth.camera.stages import StageClock
from synth.camera.writing_end import End, Footing, Freed, Order, WritePicture, WriteTruth, carry_out

if TYPE_CHECKING:
    from synth.truth import PairTruth


class FootageWriter:
    """Gives orders to write pictures and truth, from rooms that are used again and again.

    An error in writing comes up at the next call; an EOFError tells that nobody writes any more.
    """

    def __init__(self, orders: Connection, rooms: list[Room]) -> None:
        self._orders, self._rooms, self._free = orders, rooms, list(rooms)

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

    def _tell(self, order: Order) -> None:
        try:
            self._orders.send(order)
        except OSError:
            self.wait_for_end()  # why nobody listens is the last that was said

    def wait_for_end(self) -> None:
        """Hear all that is still said; raises the error that ended it, or an EOFError."""
        while True:
            self._hear()

    def _hear(self) -> None:
        try:
            answer: Freed | BaseException = self._orders.recv()
        except OSError:
            raise EOFError from None
        if isinstance(answer, BaseException):
            raise answer
        self._free.append(self._rooms[answer.room])


@contextlib.contextmanager
def writing_beside(footing: Footing, clock: StageClock) -> Iterator[FootageWriter]:
    """Write in a thread; all is written at the end."""
    ours, theirs = Pipe()
    rooms = rooms_in(memory_for(footing.shape), footing.shape)
    thread = threading.Thread(
        target=_write, args=(End(theirs, rooms), footing, clock), daemon=True, name="footage"
    )
    thread.start()
    try:
        writer = FootageWriter(ours, rooms)
        yield writer
        with contextlib.suppress(EOFError):
            writer.wait_for_end()
    finally:
        ours.close()
        thread.join()


def _write(end: End, footing: Footing, clock: StageClock) -> None:
    try:
        carry_out([end], footing, clock)
    except EOFError:
        pass  # nobody wants it any more
    except BaseException as error:
        with contextlib.suppress(OSError):
            end.orders.send(error)
    finally:
        end.orders.close()
