"""The end at which frames are written, in a thread or a process of its own.

It takes orders until it is told that there are no more, or nobody is left to give any.
"""

import contextlib
import os
import pickle
import time
import traceback
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from synth.camera.rooms import Room
from synth.camera.sensor import expose
from synth.camera.stages import StageClock
from synth.disk import naming
from synth.footage import frame_name, write_picture
from synth.truth import PairTruth
from synth.truth_file import TruthWriter

if TYPE_CHECKING:
    from synth.scene import Scene

_PATIENCE = 2.0
"""Seconds between two looks at whether the process that gives orders still lives."""


@dataclass(frozen=True)
class Footing:
    """All that must be known before the first frame.

    Attributes
    ----------
    folder : Path
    scene : Scene
    frame_times : (frame,) float64
        s.
    shape : tuple of int
        Height and width of a picture, px.
    """

    folder: Path
    scene: "Scene"
    frame_times: np.ndarray
    shape: tuple[int, int]


@dataclass(frozen=True)
class WritePicture:
    """Order to expose and write the light in a room as the picture of a frame."""

    room: int
    frame: int


@dataclass(frozen=True)
class WriteTruth:
    """Order to write the truth in a room as that of a pair: the room is free afterwards."""

    room: int
    first: int
    second: int
    camera: dict[str, float]


Order = WritePicture | WriteTruth


@dataclass(frozen=True)
class Freed:
    """Answer: a room can be filled again."""

    room: int


@dataclass(frozen=True)
class Done:
    """Answer: everything is written.

    Attributes
    ----------
    seconds : dict
        By stage.
    processor : float
        Seconds of the processor for all of them.
    peak_memory : int
        Bytes, of the process at most.
    """

    seconds: dict[str, float]
    processor: float
    peak_memory: int


def carry_out(orders: Connection, footing: Footing, rooms: list[Room]) -> None:
    """Carry out orders; `None` is the last. What goes wrong is the answer, and nothing is done after it."""
    clock, processor = StageClock(), 0.0
    try:
        with TruthWriter(footing.folder / "truth.nc", footing.scene, footing.frame_times) as file:
            while (order := _next_order(orders)) is not None:
                began = time.thread_time()
                _carry_out_one(order, footing, rooms[order.room], file, clock)
                processor += time.thread_time() - began
                if isinstance(order, WriteTruth):
                    orders.send(Freed(order.room))
        orders.send(Done(dict(clock.seconds), processor, _peak_memory()))
    except EOFError:
        pass  # nobody wants it any more
    except BaseException as error:
        with contextlib.suppress(OSError):
            orders.send(_that_travels(error))
    finally:
        orders.close()


def _next_order(orders: Connection) -> Order | None:
    giver = os.getppid()
    while not orders.poll(_PATIENCE):
        if os.getppid() != giver:
            raise EOFError
    order: Order | None = orders.recv()
    return order


def _peak_memory() -> int:
    # What `getrusage` tells of a process includes the one that it was started from.
    status = Path("/proc/self/status")
    lines = status.read_text().splitlines() if status.is_file() else []
    return next((1024 * int(line.split()[1]) for line in lines if line.startswith("VmHWM:")), 0)


def _carry_out_one(order: Order, footing: Footing, room: Room, file: TruthWriter, clock: StageClock) -> None:
    if isinstance(order, WritePicture):
        with clock.stage("exposing"):
            picture = expose(footing.scene, room.light, order.frame)
        path = footing.folder / frame_name(order.frame)
        with clock.stage("writing"), naming(path):
            write_picture(path, picture)
    else:
        with clock.stage("writing"):
            file.write(order.first, PairTruth(order.first, order.second, room.truth, order.camera))


def _that_travels(error: BaseException) -> BaseException:
    """An error as it can be sent, with the place it comes from."""
    error.add_note("".join(traceback.format_exception(error)))
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error
