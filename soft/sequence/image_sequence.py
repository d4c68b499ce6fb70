"""A sequence of pictures: grey frames, the pairs of them, their time step and their pixel size."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from soft.sequence.error import SequenceError
from soft.sequence.folder import PictureFiles
from soft.sequence.frames import ArrayFrames, Frames
from soft.sequence.masks import UserMasks
from soft.sequence.number import positive
from soft.sequence.pairs import PairSelection
from soft.sequence.region import Region
from soft.sequence.resampling import Resampling
from soft.sequence.video import VIDEO_SUFFIXES, VideoFrames, is_video


@dataclass(frozen=True, eq=False)
class ImageSequence:
    """Grey pictures of one size, in order of time, and the pairs to compare.

    Made by `open` (a folder or a video) or `from_arrays`; `select`, `resample`, `crop` and `mask` return
    changed ones. Frames of files are decoded when asked for and not kept, so a long sequence takes no more
    memory than the frames in use. Frames keep the numbers they have in the folder or video, whichever are
    used.

    Attributes
    ----------
    frames : Frames
        The pictures as they were taken.
    metres_per_pixel : float or None
        Size of a pixel on the glass in m, or None when the pictures are not calibrated.
    frame_rate : float or None
        Frames per second, or None when unknown.
    selection : PairSelection
        Which pairs are compared.
    resampling : Resampling or None
        What takes out the lens or the tilt of the camera.
    region : Region or None
        The part that is used, in px of the (resampled) picture.
    masks : UserMasks or None
        Where soil may be.
    calibration : str
        How the pixel size was found, in words; empty where it was given.
    """

    frames: Frames
    metres_per_pixel: float | None = None
    frame_rate: float | None = None
    selection: PairSelection = field(default_factory=PairSelection)
    resampling: Resampling | None = None
    region: Region | None = None
    masks: UserMasks | None = None
    calibration: str = ""

    @classmethod
    def open(
        cls,
        path: str | Path,
        *,
        metres_per_pixel: float | None = None,
        frame_rate: float | None = None,
    ) -> "ImageSequence":
        """Open a footage folder, a folder of a user's own pictures, or a video.

        Parameters
        ----------
        path : str or Path
            A folder with a `sequence.toml`; or one with at least two pictures (png, jpg, jpeg, tif, tiff,
            bmp), which are taken in natural order of their names (`a2` before `a10`); or a video (mp4, avi,
            mkv, mov, m4v, webm), which is gone through once to count its frames. It is never written to.
        metres_per_pixel : float, optional
            Pixel size in m; takes the place of the one in `sequence.toml`.
        frame_rate : float, optional
            Frames per second in 1/s; takes the place of the one in `sequence.toml` or in the video.

        Raises
        ------
        SequenceError
            If the folder or a picture is missing, unreadable or of another size than the first, or there are
            fewer than two pictures, or `sequence.toml` or an argument is wrong.
        """
        frames = _frames_at(Path(path))
        if metres_per_pixel is None:
            metres_per_pixel = getattr(frames, "metres_per_pixel", None)
        if frame_rate is None:
            frame_rate = frames.frame_rate
        return cls._checked(frames, metres_per_pixel, frame_rate)

    @classmethod
    def from_arrays(
        cls,
        pictures: Sequence[np.ndarray],
        *,
        metres_per_pixel: float | None = None,
        frame_rate: float | None = None,
    ) -> "ImageSequence":
        """Take pictures that are in memory.

        Parameters
        ----------
        pictures : sequence of arrays
            (H, W) grey or (H, W, 3) red-green-blue; uint8, uint16 (scaled to 0-255) or floating (0-255
            already).
        metres_per_pixel, frame_rate : float, optional
            Pixel size in m; frames per second in 1/s.

        Raises
        ------
        SequenceError
            If there are fewer than two, or one has another shape or type.
        """
        return cls._checked(ArrayFrames.of(pictures), metres_per_pixel, frame_rate)

    @classmethod
    def _checked(
        cls, frames: Frames, metres_per_pixel: float | None, frame_rate: float | None
    ) -> "ImageSequence":
        if metres_per_pixel is not None:
            metres_per_pixel = positive("metres_per_pixel", metres_per_pixel)
        if frame_rate is not None:
            frame_rate = positive("frame_rate", frame_rate)
        return cls(frames, metres_per_pixel, frame_rate)

    def select(
        self, *, start: int = 0, stop: int | None = None, stride: int = 1, every: int = 1
    ) -> "ImageSequence":
        """Choose the pairs, as in `PairSelection`.

        Raises
        ------
        SequenceError
            If no pair is left.
        """
        selection = PairSelection(start, stop, stride, every)
        selection.of(len(self))
        return replace(self, selection=selection)

    def resample(self, resampling: Resampling, *, metres_per_pixel: float | None = None) -> "ImageSequence":
        """See every frame on another grid, as `Lens.undistortion` or `GlassCalibration.rectification` make.

        Parameters
        ----------
        resampling : Resampling
            For frames of this size.
        metres_per_pixel : float, optional
            Of the new grid; by default, as before.

        Raises
        ------
        SequenceError
            If it is for pictures of another size, or a part was cut out already.
        """
        if self.region is not None:
            raise SequenceError("region: choose it after the pictures are resampled")
        if resampling.shape != self.frames.shape:
            raise SequenceError(
                f"calibrated for {resampling.shape[1]} x {resampling.shape[0]} px, "
                f"but the pictures have {self.frames.shape[1]} x {self.frames.shape[0]} px"
            )
        scale = self.metres_per_pixel if metres_per_pixel is None else metres_per_pixel
        return replace(self, resampling=resampling, metres_per_pixel=scale)

    def crop(self, region: Region) -> "ImageSequence":
        """Use a part of every frame only, in px of the (resampled) picture.

        Raises
        ------
        SequenceError
            If it does not lie within.
        """
        region.require_within(_shape_of(self.frames, self.resampling))
        return replace(self, region=region)

    def mask(self, path: str | Path) -> "ImageSequence":
        """Say where soil may be, by pictures drawn on the frames as they were taken, as in `UserMasks.open`.

        Raises
        ------
        SequenceError
            If they do not fit the frames.
        """
        masks = UserMasks.open(path, shape=self.frames.shape, frame_count=len(self))
        return replace(self, masks=masks)

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, index: int) -> np.ndarray:
        """Frame `index`, (H, W) float32 grey in 0-255.

        Raises
        ------
        SequenceError
            If its file cannot be decoded, or has changed its size since the sequence was opened.
        """
        if not -len(self) <= index < len(self):
            raise IndexError(index)
        picture = self.frames.read(index % len(self))
        if self._grid is not None:
            return self._grid.of(picture)
        return picture if self.region is None else self.region.of(picture)

    def usable(self, index: int) -> np.ndarray:
        """Pixels of frame `index` that the camera saw and the user's mask leaves: (H, W) bool."""
        if self.masks is None:
            return self.seen.copy()
        mask = self.masks.of(index % len(self))
        if self._grid is not None:
            return self._grid.of_mask(mask)
        return mask.copy() if self.region is None else self.region.of(mask)

    @cached_property
    def seen(self) -> np.ndarray:
        """Pixels that the camera saw, (H, W) bool: not those that resampling found beyond its picture."""
        return np.ones(self.shape, bool) if self._grid is None else self._grid.seen

    @cached_property
    def _grid(self) -> Resampling | None:
        if self.resampling is None or self.region is None:
            return self.resampling
        return self.resampling.cropped(self.region)

    def picture_pairs(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """First and second picture of every pair, in order.

        A second picture that is the next pair's first is decoded once; no more than two are held.
        """
        held, second = -1, None
        for i, j in self.pairs:
            first = second if second is not None and held == i else self[i]
            held, second = j, self[j]
            yield first, second

    @cached_property
    def names(self) -> tuple[str, ...]:
        """A name for each frame: file names, or numbers for arrays."""
        return self.frames.names

    @property
    def remark(self) -> str:
        """What should be known of the pictures before they are used, as of a film cut short; mostly empty."""
        return self.frames.remark

    @property
    def files(self) -> tuple[Path, ...]:
        """Every file that is read: pictures or video, and masks."""
        return self.frames.files + (() if self.masks is None else self.masks.files)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the pictures as used."""
        if self.region is not None:
            return self.region.height, self.region.width
        return _shape_of(self.frames, self.resampling)

    @cached_property
    def pairs(self) -> tuple[tuple[int, int], ...]:
        """Indices of the frames to compare, first and second."""
        return self.selection.of(len(self))

    @property
    def time_step(self) -> float | None:
        """Seconds from a frame to the next, or None when the frame rate is unknown."""
        return None if self.frame_rate is None else 1.0 / self.frame_rate

    @property
    def pair_time(self) -> float | None:
        """Seconds from the first picture of a pair to the second, or None when the frame rate is unknown."""
        return None if self.time_step is None else self.selection.stride * self.time_step

    @property
    def calibrated(self) -> bool:
        """Whether displacements in px can be told in m/s."""
        return self.metres_per_pixel is not None and self.frame_rate is not None


def _frames_at(path: Path) -> PictureFiles | VideoFrames:
    if path.is_dir():
        return PictureFiles.open(path)
    if is_video(path):
        return VideoFrames.open(path)
    videos = ", ".join(suffix[1:] for suffix in VIDEO_SUFFIXES)
    what = "is a file" if path.exists() else "does not exist"
    raise SequenceError(f"{path}: {what}: expected a folder of pictures, or a video ({videos})")


def _shape_of(frames: Frames, resampling: Resampling | None) -> tuple[int, int]:
    if resampling is None:
        return frames.shape
    height, width = resampling.source.shape[:2]
    return height, width
