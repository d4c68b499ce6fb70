"""Where frames come from: what every source of them gives, and the plainest one, memory."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from soft.sequence.error import SequenceError
from soft.sequence.picture import require_same_shape, to_grey


class Frames(Protocol):
    """Grey pictures of one size, read one at a time."""

    @property
    def names(self) -> tuple[str, ...]:
        """A name for each frame."""
        ...

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of every frame as stored."""
        ...

    @property
    def files(self) -> tuple[Path, ...]:
        """The files that the frames are read from, empty for memory."""
        ...

    @property
    def remark(self) -> str:
        """What should be known of them before they are used; mostly empty."""
        ...

    def read(self, index: int) -> np.ndarray:
        """Frame `index`, (H, W) float32 grey in 0-255, of the reader's own."""
        ...


@dataclass(frozen=True, eq=False)
class ArrayFrames:
    """Frames in memory."""

    arrays: tuple[np.ndarray, ...]

    @classmethod
    def of(cls, pictures: Sequence[np.ndarray]) -> "ArrayFrames":
        """Make grey frames of arrays as in `to_grey`.

        Raises
        ------
        SequenceError
            If there are fewer than two, or one has another shape or type.
        """
        frames = tuple(
            to_grey(np.asarray(picture), name=f"picture {k}") for k, picture in enumerate(pictures)
        )
        require_two(len(frames), "from_arrays")
        for k, frame in enumerate(frames):
            require_same_shape(frame.shape, frames[0].shape, f"picture {k}")
        return cls(frames)

    @property
    def names(self) -> tuple[str, ...]:
        """Numbers."""
        return tuple(str(k) for k in range(len(self.arrays)))

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of every frame."""
        height, width = self.arrays[0].shape
        return height, width

    @property
    def files(self) -> tuple[Path, ...]:
        """None."""
        return ()

    @property
    def remark(self) -> str:
        """None."""
        return ""

    def read(self, index: int) -> np.ndarray:
        """A copy, so that a caller's changes stay the caller's."""
        return self.arrays[index].copy()


def require_two(count: int, where: str) -> None:
    """Refuse fewer than two pictures."""
    if count < 2:
        raise SequenceError(
            f"{where}: {count} picture{'' if count == 1 else 's'}: at least 2 are needed for motion"
        )
