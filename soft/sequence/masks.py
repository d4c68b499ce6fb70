"""A user's masks: where soil may be, drawn on the pictures as they were taken."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from soft.sequence.error import SequenceError
from soft.sequence.folder import common_shape, sorted_pictures
from soft.sequence.picture import read_picture, require_same_shape, stored_shape

MASK_SUFFIXES = (".png", ".tif", ".tiff", ".bmp")
"""JPEG is left out: around what is drawn it leaves grey levels that are not quite zero."""

MOST_LEVELS, MOST_OTHERS = 8, 0.1
"""Grey levels of a mask, and the share of its pixels that may have others, as along smooth edges. A
photograph taken for a mask would hide nothing, and nobody would be told."""


@dataclass(frozen=True, eq=False)
class UserMasks:
    """One mask for all frames, or one for each; what is not black may be soil.

    Attributes
    ----------
    files : tuple of Path
        One picture, or as many as there are frames.
    shape : (int, int)
        Rows and columns of each.
    """

    files: tuple[Path, ...]
    shape: tuple[int, int]

    @classmethod
    def open(cls, path: str | Path, *, shape: tuple[int, int], frame_count: int) -> "UserMasks":
        """Find the masks of a sequence, and look at their headers.

        Parameters
        ----------
        path : str or Path
            A picture (png, tif, bmp): the same for every frame; or a folder of as many as there are frames,
            in natural order of their names.
        shape : (int, int)
            Rows and columns of the frames as taken.
        frame_count : int
            Frames of the sequence.

        Raises
        ------
        SequenceError
            If a mask is missing, of another size than the frames, or a JPEG; or there are more or fewer. A
            photograph is refused when it is used.
        """
        path = Path(path)
        if path.is_dir():
            files = sorted_pictures(path)
            if len(files) != frame_count:
                raise SequenceError(f"masks {path}: {len(files)} pictures for {frame_count} frames")
            found = common_shape(files)
        elif path.is_file():
            files, found = [path], stored_shape(path)
        else:
            raise SequenceError(f"masks {path}: neither a picture nor a folder of pictures")
        for file in files:
            _require_lossless(file)
        if found != shape:
            raise SequenceError(
                f"masks {path}: {found[1]} x {found[0]} px, "
                f"but the pictures have {shape[1]} x {shape[0]} px: "
                "masks are drawn on the pictures as they were taken"
            )
        return cls(tuple(files), shape)

    @property
    def moving(self) -> bool:
        """Whether each frame has its own."""
        return len(self.files) > 1

    def of(self, frame: int) -> np.ndarray:
        """Where soil may be in a frame, (H, W) bool."""
        return self._read(self.files[frame]) if self.moving else self._static

    @cached_property
    def _static(self) -> np.ndarray:
        return self._read(self.files[0])

    def _read(self, file: Path) -> np.ndarray:
        drawn = read_picture(file)
        require_same_shape(drawn.shape, self.shape, f"mask {file}")
        counts = np.sort(np.bincount(drawn.astype(np.uint8).ravel()))
        if counts[:-MOST_LEVELS].sum() > MOST_OTHERS * drawn.size:
            raise SequenceError(
                f"mask {file}: has too many grey levels for something drawn: must be black where there is "
                "never soil, and white elsewhere"
            )
        return drawn > 0


def _require_lossless(file: Path) -> None:
    if file.suffix.lower() not in MASK_SUFFIXES:
        allowed = ", ".join(suffix[1:] for suffix in MASK_SUFFIXES)
        raise SequenceError(f"mask {file}: allowed are {allowed}, which keep black black")
