"""Which frames are compared with which."""

from dataclasses import dataclass

from soft.sequence.error import SequenceError
from soft.sequence.number import whole


@dataclass(frozen=True)
class PairSelection:
    """A choice of frame pairs (i, i + `stride`), i = `start`, `start` + `every`, ...

    Consecutive frames are the default. `every` = `stride` = n thins the sequence out: (0, n), (n, 2 n), ...
    `every` = n alone takes a look now and then at full speed: (0, 1), (n, n + 1), ... `stride` = n alone has
    pairs that overlap: (0, n), (1, n + 1), ...

    Attributes
    ----------
    start : int
        Frame of the first pair.
    stop : int or None
        Frames from this one on are not used; None: up to the end.
    stride : int
        Frames from the first of a pair to its second.
    every : int
        Frames from the first of a pair to the first of the next.

    Raises
    ------
    SequenceError
        If one is not a whole number, or too small.
    """

    start: int = 0
    stop: int | None = None
    stride: int = 1
    every: int = 1

    def __post_init__(self) -> None:
        whole("start", self.start, least=0)
        if self.stop is not None:
            whole("stop", self.stop, least=1)
        whole("stride", self.stride, least=1)
        whole("every", self.every, least=1)

    def of(self, frame_count: int) -> tuple[tuple[int, int], ...]:
        """Choose the pairs of a sequence of so many frames, in order.

        Raises
        ------
        SequenceError
            If there is none.
        """
        stop = frame_count if self.stop is None else min(self.stop, frame_count)
        pairs = tuple((k, k + self.stride) for k in range(self.start, stop - self.stride, self.every))
        if not pairs:
            raise SequenceError(
                f"start {self.start}, stop {self.stop or 'none'}, stride {self.stride}: no pair in "
                f"{frame_count} frames: start + stride must be below stop and below {frame_count}"
            )
        return pairs
