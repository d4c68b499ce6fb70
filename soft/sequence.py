"""A sequence of pictures: grey frames, their time step and their pixel size."""

import math
import tomllib
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import numpy as np

from soft.natural_order import natural_key

SEQUENCE_FILE = "sequence.toml"
SCHEMA_VERSION = 1
PICTURE_SUFFIXES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp")

# ITU-R BT.601 luma of red, green and blue: what "black and white" means for the usual 8-bit photograph.
LUMINANCE = (0.299, 0.587, 0.114)


class SequenceError(ValueError):
    """Pictures that cannot be used as a sequence; the message is one line for the person who gave them."""


@dataclass(frozen=True, eq=False)
class ImageSequence:
    """Grey pictures of one size, in order of time.

    Made by `open` (a folder) or `from_arrays`. Frames of a folder are decoded when asked for and not kept, so
    a long sequence takes no more memory than the frames in use.

    Attributes
    ----------
    names : tuple of str
        A name for each frame: file names, or numbers for arrays.
    shape : (int, int)
        Rows and columns of every frame.
    metres_per_pixel : float or None
        Size of a pixel on the glass in m, or None when the pictures are not calibrated.
    frame_rate : float or None
        Frames per second, or None when unknown.
    """

    names: tuple[str, ...]
    shape: tuple[int, int]
    metres_per_pixel: float | None
    frame_rate: float | None
    _sources: tuple[Path | np.ndarray, ...]

    @classmethod
    def open(
        cls,
        path: str | Path,
        *,
        metres_per_pixel: float | None = None,
        frame_rate: float | None = None,
    ) -> "ImageSequence":
        """Open a footage folder, or a folder of a user's own pictures, without decoding anything.

        Parameters
        ----------
        path : str or Path
            A folder with a `sequence.toml`, or one with at least two pictures (png, jpg, jpeg, tif, tiff,
            bmp), which are taken in natural order of their names (`a2` before `a10`). It is never written to.
        metres_per_pixel : float, optional
            Pixel size in m; takes the place of the one in `sequence.toml`.
        frame_rate : float, optional
            Frames per second in 1/s; takes the place of the one in `sequence.toml`.

        Raises
        ------
        SequenceError
            If the folder or a picture is missing, unreadable or of another size than the first, or there are
            fewer than two pictures, or `sequence.toml` or an argument is wrong.
        """
        folder = Path(path)
        if not folder.is_dir():
            what = "is a file" if folder.exists() else "does not exist"
            raise SequenceError(f"{folder}: {what}: expected a folder of pictures")
        stored_scale, stored_rate = None, None
        if (folder / SEQUENCE_FILE).is_file():
            files, stored_scale, stored_rate = _read_sequence_file(folder / SEQUENCE_FILE)
        else:
            files = _pictures_in(folder)
        names = tuple(file.relative_to(folder).as_posix() for file in files)
        return cls._build(
            names,
            _common_shape(files),
            stored_scale if metres_per_pixel is None else metres_per_pixel,
            stored_rate if frame_rate is None else frame_rate,
            tuple(files),
        )

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
        frames = tuple(
            to_grey(np.asarray(picture), name=f"picture {k}") for k, picture in enumerate(pictures)
        )
        _require_two(len(frames), "from_arrays")
        for k, frame in enumerate(frames):
            _require_same_shape(frame.shape, frames[0].shape, f"picture {k}")
        names = tuple(str(k) for k in range(len(frames)))
        return cls._build(names, frames[0].shape, metres_per_pixel, frame_rate, frames)

    @classmethod
    def _build(cls, names, shape, metres_per_pixel, frame_rate, sources) -> "ImageSequence":
        return cls(
            names,
            shape,
            None if metres_per_pixel is None else _positive("metres_per_pixel", metres_per_pixel),
            None if frame_rate is None else _positive("frame_rate", frame_rate),
            sources,
        )

    def __len__(self) -> int:
        return len(self._sources)

    def __getitem__(self, index: int) -> np.ndarray:
        """Frame `index`, (H, W) float32 grey in 0-255.

        Raises
        ------
        SequenceError
            If its file cannot be decoded, or has changed its size since the sequence was opened.
        """
        source = self._sources[index]
        if isinstance(source, np.ndarray):
            return source.copy()
        picture = read_picture(source)
        _require_same_shape(picture.shape, self.shape, str(source))
        return picture

    @property
    def pairs(self) -> tuple[tuple[int, int], ...]:
        """Indices of consecutive frames, first and second."""
        return tuple((k, k + 1) for k in range(len(self) - 1))

    @property
    def time_step(self) -> float | None:
        """Seconds from a frame to the next, or None when the frame rate is unknown."""
        return None if self.frame_rate is None else 1.0 / self.frame_rate

    @property
    def calibrated(self) -> bool:
        """Whether displacements in px can be told in m/s."""
        return self.metres_per_pixel is not None and self.frame_rate is not None


def read_picture(path: Path) -> np.ndarray:
    """Decode one picture file to (H, W) float32 grey in 0-255, rows as stored (EXIF rotation is not applied).

    A rig's camera often looks down through a mirror, where its orientation sensor reports chance: ignoring it
    keeps every frame the same way up.

    Raises
    ------
    SequenceError
        If the file is missing, damaged, cut short, or neither 8 nor 16 bits deep.
    """
    # Pillow alone reports a JPEG that is cut short; OpenCV alone keeps 16-bit colour.
    decode = _decode_jpeg if path.suffix.lower() in (".jpg", ".jpeg") else _decode
    return to_grey(decode(path), name=str(path))


def to_grey(picture: np.ndarray, *, name: str) -> np.ndarray:
    """Grey levels 0-255 as float32 from grey or colour of 8 or 16 bits; nothing is rounded.

    Parameters
    ----------
    picture : (H, W), (H, W, 1), (H, W, 3) or (H, W, 4) array
        Red, green, blue in this order; a fourth channel (opacity) is dropped. uint8, uint16 or floating
        0-255.
    name : str
        What to call the picture in an error message.
    """
    if picture.dtype not in (np.uint8, np.uint16, np.float32, np.float64):
        raise SequenceError(f"{name}: type {picture.dtype}: allowed are 8-bit, 16-bit and floating 0-255")
    if picture.ndim == 3 and picture.shape[2] == 1:
        picture = picture[:, :, 0]
    if picture.ndim == 3 and picture.shape[2] in (3, 4):
        red, green, blue = (picture[:, :, c].astype(np.float32) for c in range(3))
        grey = LUMINANCE[0] * red + LUMINANCE[1] * green + LUMINANCE[2] * blue
    elif picture.ndim == 2:
        grey = picture.astype(np.float32)
    else:
        raise SequenceError(f"{name}: shape {picture.shape}: allowed are (H, W), (H, W, 3) and (H, W, 4)")
    if picture.size == 0:
        raise SequenceError(f"{name}: shape {picture.shape}: the picture is empty")
    if picture.dtype == np.uint16:
        grey = grey / np.float32(257.0)  # 65535 / 257 is 255 exactly
    # The weighted sum of white may be rounded to a little more than white.
    return np.minimum(grey, np.float32(255.0)) if picture.ndim == 3 and picture.dtype.kind == "u" else grey


def _decode(path: Path) -> np.ndarray:
    import cv2

    picture = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if picture is None:
        raise SequenceError(f"{path}: {_why_unreadable(path)}")
    if picture.ndim == 3 and picture.shape[2] >= 3:
        picture = picture[:, :, [2, 1, 0, *range(3, picture.shape[2])]]
    return picture


def _decode_jpeg(path: Path) -> np.ndarray:
    from PIL import Image

    try:
        with Image.open(path) as image:
            return np.asarray(image if image.mode in ("L", "RGB") else image.convert("RGB"))
    except (OSError, SyntaxError, Image.DecompressionBombError) as error:
        raise SequenceError(f"{path}: {_why_unreadable(path)}") from error


def _stored_shape(path: Path) -> tuple[int, int]:
    """Rows and columns of a picture file from its header alone."""
    from PIL import Image

    try:
        # What a damaged header makes Pillow warn of is told by the error.
        with warnings.catch_warnings(action="ignore"), Image.open(path) as image:
            return image.height, image.width
    except (OSError, SyntaxError, Image.DecompressionBombError) as error:
        raise SequenceError(f"{path}: {_why_unreadable(path)}") from error


def _why_unreadable(path: Path) -> str:
    return "not a readable picture (damaged or cut short?)" if path.is_file() else "no such picture"


def _pictures_in(folder: Path) -> list[Path]:
    files = [file for file in folder.iterdir() if _is_picture(file)]
    if not files:
        allowed = ", ".join(suffix[1:] for suffix in PICTURE_SUFFIXES)
        raise SequenceError(f"{folder}: no {SEQUENCE_FILE} and no picture in it: allowed are {allowed}")
    return sorted(files, key=natural_key)


def _is_picture(file: Path) -> bool:
    return file.suffix.lower() in PICTURE_SUFFIXES and not file.name.startswith(".") and file.is_file()


def _common_shape(files: list[Path]) -> tuple[int, int]:
    _require_two(len(files), str(files[0].parent) if files else SEQUENCE_FILE)
    first = _stored_shape(files[0])
    for file in files[1:]:
        _require_same_shape(_stored_shape(file), first, str(file))
    return first


def _require_two(count: int, where: str) -> None:
    if count < 2:
        raise SequenceError(
            f"{where}: {count} picture{'' if count == 1 else 's'}: at least 2 are needed for motion"
        )


def _require_same_shape(shape: tuple[int, ...], first: tuple[int, ...], name: str) -> None:
    if shape != first:
        raise SequenceError(
            f"{name}: {shape[1]} x {shape[0]} px, but the first picture has {first[1]} x {first[0]} px: "
            "all must have one size"
        )


def _positive(name: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not (0 < value < math.inf):
        raise SequenceError(f"{name}: {value!r}: must be a number above 0")
    return float(value)


def _read_sequence_file(path: Path) -> tuple[list[Path], float, float]:
    """Frame files, metres per pixel and frame rate from a `sequence.toml`."""
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise SequenceError(f"{path}: not valid TOML: {error}") from error
    for key in ("schema_version", "frame_rate", "metres_per_pixel", "frames"):
        if key not in table:
            raise SequenceError(f"{path}: {key} is missing")
    if table["schema_version"] != SCHEMA_VERSION:
        raise SequenceError(
            f"{path}: schema_version {table['schema_version']!r}: this reads {SCHEMA_VERSION}"
        )
    try:
        scale = _positive("metres_per_pixel", table["metres_per_pixel"])
        rate = _positive("frame_rate", table["frame_rate"])
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
    _require_two(len(frames), str(path))
    return [path.parent / name for name in frames]
