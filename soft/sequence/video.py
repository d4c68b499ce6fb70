"""Frames of a video file, streamed: memory holds one frame at a time."""

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from soft.sequence.error import SequenceError
from soft.sequence.frames import require_two
from soft.sequence.picture import require_same_shape, to_grey

VIDEO_SUFFIXES = (".mp4", ".avi", ".mkv", ".mov", ".m4v", ".webm")

# Of a pair the first and the second frame: each reader only ever goes forward.
_READER_COUNT = 2
_COUNT_IS_OFF_BY = 1
"""Frames; some containers tell a duration only, from which the count is reckoned."""


@dataclass(frozen=True, eq=False)
class VideoFrames:
    """Frames of one video file.

    A video is read from its beginning, frame by frame: with many codecs, jumps land on other frames than
    asked for. Two readers follow the first and the second pictures of pairs; asking for frames in any other
    order gives the right ones, but starts over.

    Attributes
    ----------
    path : Path
    shape : (int, int)
        Rows and columns of every frame, as stored: a rotation that the file asks for is not applied.
    frame_count : int
        Frames that can be decoded.
    announced_count : int
        Frames that the file tells of; 0 where it does not.
    frame_rate : float or None
        Frames per second as the file tells; None where it does not. A high-speed camera's file often tells
        the rate to play it at.
    """

    path: Path
    shape: tuple[int, int]
    frame_count: int
    announced_count: int
    frame_rate: float | None
    _readers: list["_Reader"] = field(default_factory=list)

    @classmethod
    def open(cls, path: Path) -> "VideoFrames":
        """Go through a video once and count its frames.

        Raises
        ------
        SequenceError
            If it cannot be read, or has fewer than two frames.
        """
        capture = _capture(path)
        rate, announced = _frame_rate(capture), _announced_count(capture)
        read, first = capture.read()
        if not read:
            capture.release()
            raise SequenceError(f"{path}: a video without a frame that can be decoded")
        count = 1
        while capture.grab():
            count += 1
        capture.release()
        require_two(count, str(path))
        return cls(path, (first.shape[0], first.shape[1]), count, announced, rate)

    @property
    def names(self) -> tuple[str, ...]:
        """The file's name and the frame's number."""
        return tuple(f"{self.path.name}#{k}" for k in range(self.frame_count))

    @property
    def files(self) -> tuple[Path, ...]:
        """The one file."""
        return (self.path,)

    @property
    def remark(self) -> str:
        """Whether fewer frames could be decoded than the file tells of."""
        if self.frame_count + _COUNT_IS_OFF_BY >= self.announced_count:
            return ""
        return (
            f"{self.path.name}: {self.frame_count} of the {self.announced_count} frames that it tells of "
            "could be decoded: is it cut short or damaged?"
        )

    def read(self, index: int) -> np.ndarray:
        """Frame `index`, (H, W) float32 grey in 0-255.

        Raises
        ------
        SequenceError
            If the file cannot be decoded that far any more.
        """
        reader = self._reader_for(index)
        picture = reader.read(index)
        if picture is None:
            raise SequenceError(
                f"{self.path}: frame {index} of {self.frame_count} cannot be decoded any more"
            )
        grey = to_grey(picture[:, :, ::-1], name=f"{self.path.name}#{index}")
        require_same_shape(grey.shape, self.shape, f"{self.path.name}#{index}")
        return grey

    def _reader_for(self, index: int) -> "_Reader":
        """Take the reader that has least to skip; where every one is past `index`, one starts over."""
        if not 0 <= index < self.frame_count:
            raise IndexError(index)
        before = [reader for reader in self._readers if reader.position <= index]
        if before:
            reader = max(before, key=lambda one: one.position)
        else:
            if len(self._readers) == _READER_COUNT:
                self._readers.pop(0).close()
            reader = _Reader(self.path)
        # The last one used is the last one given up.
        self._readers[:] = [one for one in self._readers if one is not reader] + [reader]
        return reader


class _Reader:
    """Reads a video forward."""

    def __init__(self, path: Path) -> None:
        self._capture = _capture(path)
        self.position = 0

    def read(self, index: int) -> np.ndarray | None:
        """Skip to a frame that is not yet past and decode it: (H, W, 3) blue, green, red; None at the end."""
        while self.position < index:
            if not self._capture.grab():
                return None
            self.position += 1
        read, picture = self._capture.read()
        self.position += 1
        return picture if read else None

    def close(self) -> None:
        self._capture.release()


def is_video(file: Path) -> bool:
    """Whether a path is a file that its name says is a video."""
    return file.suffix.lower() in VIDEO_SUFFIXES and file.is_file()


def _capture(path: Path) -> Any:
    import cv2

    capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
    if not capture.isOpened():
        raise SequenceError(f"{path}: not a readable video (damaged, cut short, or of an unknown codec?)")
    capture.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)
    return capture


def _frame_rate(capture: Any) -> float | None:
    import cv2

    rate = float(capture.get(cv2.CAP_PROP_FPS))
    return rate if 0 < rate < math.inf else None


def _announced_count(capture: Any) -> int:
    import cv2

    count = float(capture.get(cv2.CAP_PROP_FRAME_COUNT))
    return round(count) if 0 < count < math.inf else 0
