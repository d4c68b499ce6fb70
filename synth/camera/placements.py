"""Where the micro-grains are, frame by frame: all frames in one process, or some of them in each of several.

Every frame follows from the one before. Processes that share the frames among them therefore hand on where
the grains are as soon as it is known, and do the rest, which is most of the work, at the same time.
"""

import mmap
import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from synth.camera.motion import Motion, Placement
from synth.camera.shared_arrays import Forms, arrays_in, size_of

if TYPE_CHECKING:
    from synth.camera.stages import StageClock

_ARRAYS = {"x": "f8", "z": "f8", "angle": "f8", "generation": "i4", "alive": "u1"}


@dataclass(frozen=True)
class Step:
    """A frame, and where the micro-grains are around it.

    Attributes
    ----------
    frame : int
    previous : Placement or None
        One frame earlier; None in the first frame.
    placement : Placement
    following : Placement or None
        One frame later; None in the last frame.
    """

    frame: int
    previous: Placement | None
    placement: Placement
    following: Placement | None


def every_step(motion: Motion, count: int, clock: "StageClock") -> Iterator[Step]:
    """Every frame of `count`, one after the other."""
    previous, placement = None, motion.start()
    for frame in range(count):
        following = None
        if frame + 1 < count:
            with clock.stage("moving"):
                following = motion.advance(placement)
        yield Step(frame, previous, placement, following)
        if following is not None:
            previous, placement = placement, following


@dataclass(frozen=True)
class Baton:
    """What one of several processes in a ring hears from the one before it, and tells the one after it.

    Attributes
    ----------
    number : int
        Of this process; it makes this frame, and then every `size`-th.
    size : int
        How many processes there are.
    heard, told : int
        File descriptors of pipes; a byte says that the next frame's grains are in place.
    """

    number: int
    size: int
    heard: int
    told: int

    def wait(self) -> None:
        """Wait for the grains of this process's next frame; an EOFError tells that they will never come."""
        if not os.read(self.heard, 1):
            raise EOFError

    def pass_on(self) -> None:
        """Tell that the grains of the next process's frame are in place."""
        os.write(self.told, b".")


def own_steps(motion: Motion, count: int, clock: "StageClock", baton: Baton, memory: int) -> Iterator[Step]:
    """Every frame of `count` that is this process's own.

    Parameters
    ----------
    memory : int
        File descriptor of memory that all of them share; made as large as is needed.
    """
    start = motion.start()
    ring = _Ring(memory, baton.size + 2, start)
    for frame in range(baton.number, count, baton.size):
        if frame == 0:
            ring.put(start)
        else:
            with clock.stage("waiting"):
                baton.wait()
        placement, following = ring.at(frame), None
        if frame + 1 < count:
            with clock.stage("moving"):
                following = ring.put(motion.advance(placement, ring.at(frame + 1)))
            baton.pass_on()
        yield Step(frame, ring.at(frame - 1) if frame else None, placement, following)


class _Ring:
    """Placements of as many frames as are in use at a time, in shared memory.

    A process at a frame needs the one before and the one after it. The slowest can be `size` - 1 frames
    behind the one that puts the next placement, so `size` + 2 are in use.
    """

    def __init__(self, memory: int, slots: int, like: Placement) -> None:
        forms: Forms = {
            name: (dtype, like.x.shape) for name, dtype in _ARRAYS.items() if getattr(like, name) is not None
        }
        slot = size_of(forms)
        size = max(slots * slot, 1)
        os.ftruncate(memory, size)  # all processes strew the same grains, so all make it the same
        shared = mmap.mmap(memory, size, mmap.MAP_SHARED)
        self._slots = [arrays_in(shared, forms, number * slot) for number in range(slots)]

    def at(self, frame: int) -> Placement:
        """Placement that was put there for a frame."""
        return Placement(frame, **self._slots[frame % len(self._slots)])

    def put(self, placement: Placement) -> Placement:
        """Put a placement in, where it is not in already, and return it as it lies there."""
        for name, values in self._slots[placement.frame % len(self._slots)].items():
            if getattr(placement, name) is not values:
                values[:] = getattr(placement, name)
        return self.at(placement.frame)
