"""One picture file: its size, and its grey levels."""

import warnings
from pathlib import Path

import numpy as np

from soft.sequence.error import SequenceError

PICTURE_SUFFIXES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp")

# ITU-R BT.601 luma of red, green and blue: what "black and white" means for the usual 8-bit photograph.
LUMINANCE = (0.299, 0.587, 0.114)


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


def stored_shape(path: Path) -> tuple[int, int]:
    """Rows and columns of a picture file, from its header alone."""
    from PIL import Image

    try:
        # What a damaged header makes Pillow warn of is told by the error.
        with warnings.catch_warnings(action="ignore"), Image.open(path) as image:
            return image.height, image.width
    except (OSError, SyntaxError, Image.DecompressionBombError) as error:
        raise SequenceError(f"{path}: {_why_unreadable(path)}") from error


def is_picture(file: Path) -> bool:
    """Whether a path is a file that its name says is a picture."""
    return file.suffix.lower() in PICTURE_SUFFIXES and not file.name.startswith(".") and file.is_file()


def require_same_shape(shape: tuple[int, ...], first: tuple[int, ...], name: str) -> None:
    """Refuse a picture of another size than the first one's, (rows, columns)."""
    if shape != first:
        raise SequenceError(
            f"{name}: {shape[1]} x {shape[0]} px, but the first picture has {first[1]} x {first[0]} px: "
            "all must have one size"
        )


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


def _why_unreadable(path: Path) -> str:
    return "not a readable picture (damaged or cut short?)" if path.is_file() else "no such picture"
