"""Frames that are picture files in a folder: a footage folder's, or all there are."""

from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import numpy as np

from soft.natural_order import natural_key
from soft.sequence.error import SequenceError
from soft.sequence.frames import require_two
from soft.sequence.number import positive
from soft.sequence.picture import PICTURE_SUFFIXES, is_picture, read_picture, require_same_shape, stored_shape
from soft.toml_file import read_toml

SEQUENCE_FILE = "sequence.toml"
SCHEMA_VERSION = 1


@dataclass(frozen=True, eq=False)
class PictureFiles:
    """Frames that are files of their own, decoded when asked for and not kept.

    Attributes
    ----------
    folder : Path
        Where they lie.
    files : tuple of Path
        In order of time.
    shape : (int, int)
        Rows and columns of every file.
    metres_per_pixel, frame_rate : float or None
        As the folder's `sequence.toml` tells them, in m and 1/s.
    """

    folder: Path
    files: tuple[Path, ...]
    shape: tuple[int, int]
    metres_per_pixel: float | None
    frame_rate: float | None

    @classmethod
    def open(cls, folder: Path) -> "PictureFiles":
        """Find a folder's pictures and look at their headers.

        Raises
        ------
        SequenceError
            If a picture is missing, unreadable or of another size than the first, there are fewer than two,
            or `sequence.toml` is wrong.
        """
        scale, rate = None, None
        if (folder / SEQUENCE_FILE).is_file():
            files, scale, rate = _read_sequence_file(folder / SEQUENCE_FILE)
        else:
            files = _pictures_in(folder)
        require_two(len(files), str(folder))
        return cls(folder, tuple(files), common_shape(files), scale, rate)

    @property
    def names(self) -> tuple[str, ...]:
        """Paths within the folder."""
        return tuple(file.relative_to(self.folder).as_posix() for file in self.files)

    @property
    def remark(self) -> str:
        """None: a picture that cannot be read is refused."""
        return ""

    def read(self, index: int) -> np.ndarray:
        """Decode a file, which must have kept its size since the folder was opened."""
        picture = read_picture(self.files[index])
        require_same_shape(picture.shape, self.shape, str(self.files[index]))
        return picture


def sorted_pictures(folder: Path) -> list[Path]:
    """Pictures in a folder, in natural order of their names (`a2` before `a10`)."""
    return sorted((file for file in folder.iterdir() if is_picture(file)), key=natural_key)


def common_shape(files: list[Path]) -> tuple[int, int]:
    """Rows and columns that all files have.

    Raises
    ------
    SequenceError
        If one has others, or cannot be read.
    """
    first = stored_shape(files[0])
    for file in files[1:]:
        require_same_shape(stored_shape(file), first, str(file))
    return first


def _pictures_in(folder: Path) -> list[Path]:
    files = sorted_pictures(folder)
    if not files:
        allowed = ", ".join(suffix[1:] for suffix in PICTURE_SUFFIXES)
        raise SequenceError(f"{folder}: no {SEQUENCE_FILE} and no picture in it: allowed are {allowed}")
    return files


def _read_sequence_file(path: Path) -> tuple[list[Path], float, float]:
    """Frame files, metres per pixel and frame rate from a `sequence.toml`."""
    try:
        table = read_toml(path)
    except ValueError as error:
        raise SequenceError(f"{path}: not valid TOML: {error}") from error
    for key in ("schema_version", "frame_rate", "metres_per_pixel", "frames"):
        if key not in table:
            raise SequenceError(f"{path}: {key} is missing")
    if table["schema_version"] != SCHEMA_VERSION:
        raise SequenceError(
            f"{path}: schema_version {table['schema_version']!r}: this reads {SCHEMA_VERSION}"
        )
    try:
        scale = positive("metres_per_pixel", table["metres_per_pixel"])
        rate = positive("frame_rate", table["frame_rate"])
    except SequenceError as error:
        raise SequenceError(f"{path}: {error}") from error
    return _listed_frames(path, table["frames"]), scale, rate


def _listed_frames(path: Path, frames: object) -> list[Path]:
    if not isinstance(frames, list) or not all(isinstance(name, str) and name for name in frames):
        raise SequenceError(f"{path}: frames: {frames!r}: must be a list of picture paths")
    for name in frames:
        relative = PurePosixPath(name)
        if relative.is_absolute() or ".." in relative.parts:
            raise SequenceError(f"{path}: frames: {name!r}: must lie inside the folder")
    return [path.parent / name for name in frames]
