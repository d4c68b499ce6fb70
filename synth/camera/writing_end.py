"""The end at which frames are written: noise, compression, files, while the next ones are rendered."""

from collections.abc import Callable, Sequence
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


@dataclass(frozen=True, eq=False)
class End:
    """From where orders come, and the rooms they speak of."""

    orders: Connection
    rooms: list[Room]

    def next_order(self) -> Order:
        """Wait for the next order, or raise what came instead of it."""
        order: Order | BaseException = self.orders.recv()
        if isinstance(order, BaseException):
            raise order
        return order


def carry_out(
    ends: Sequence[End],
    footing: Footing,
    clock: StageClock,
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Write all frames in their order, whatever the order they are made in: the files are always the same.

    Parameters
    ----------
    ends : sequence of End
        The n-th gives the orders for every frame whose number leaves n over, divided by their count.
    footing : Footing
    clock : StageClock
        Adds up how long each stage takes.
    progress : callable, optional
        Called with the frames written and the frames in all.
    """
    count = len(footing.frame_times)
    with TruthWriter(footing.folder / "truth.nc", footing.scene, footing.frame_times) as file:
        for frame in range(count):
            end = ends[frame % len(ends)]
            for _ in range(2 if frame + 1 < count else 1):
                order = end.next_order()
                _carry_out_one(order, footing, end.rooms[order.room], file, clock)
                if isinstance(order, WriteTruth):
                    end.orders.send(Freed(order.room))
            if progress is not None:
                progress(frame + 1, count)


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
