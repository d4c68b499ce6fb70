"""Film files: VP9 in mp4, or an animated gif, written picture by picture."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any, Protocol

import numpy as np

from soft.figures.page import FigureError, require_suffix

FILM_SUFFIXES = (".mp4", ".gif")

# VP9 (libvpx, no patents to license), which Firefox, Chrome, Edge and Safari play; the free builds of OpenCV
# cannot write H.264, and the MPEG-4 part 2 that they also write, browsers do not play.
_CODEC = "vp09"
_SLOWEST, _FASTEST = 0.5, 60.0
_GIF_TICK = 0.01  # s, a gif's unit of time; viewers slow down what is shorter than two
_GIF_COLOURS = 255


class FilmFile(Protocol):
    """Takes the pictures of a film one after the other."""

    def add(self, picture: np.ndarray) -> None:
        """Append a picture, (H, W, 3) uint8, red, green, blue; all of one size."""
        ...


@contextmanager
def film_file(path: str | Path, *, rate: float, kind: str | None = None) -> "Iterator[FilmFile]":
    """Write a film; memory holds one picture of it at a time.

    Parameters
    ----------
    path : str or Path
        The file.
    rate : float
        Pictures a second, kept within what players can do (0.5 to 60).
    kind : str, optional
        `.mp4` or `.gif`; by default the suffix of `path`.

    Raises
    ------
    FigureError
        If it is another, or cannot be written.
    """
    path = Path(path)
    kind = require_suffix(path, FILM_SUFFIXES) if kind is None else kind
    rate = float(np.clip(rate, _SLOWEST, _FASTEST))
    if kind == ".gif":
        with path.open("wb") as file:
            gif = _Gif(file, rate)
            yield gif
            gif.finish()
        return
    video = _Video(path, rate)
    try:
        yield video
    finally:
        video.close()


class _Video:
    """VP9 in mp4, by OpenCV; an odd last row or column is left out, as the codec has no room for it."""

    def __init__(self, path: Path, rate: float) -> None:
        self._path, self._rate = path, rate
        self._writer: Any = None

    def add(self, picture: np.ndarray) -> None:
        import cv2

        height, width = (side // 2 * 2 for side in picture.shape[:2])
        if self._writer is None:
            codec = cv2.VideoWriter.fourcc(*_CODEC)
            self._writer = cv2.VideoWriter(str(self._path), codec, self._rate, (width, height))
            if not self._writer.isOpened():
                raise FigureError(f"{self._path}: this OpenCV ({cv2.__version__}) cannot write VP9 into .mp4")
        self._writer.write(cv2.cvtColor(picture[:height, :width], cv2.COLOR_RGB2BGR))

    def close(self) -> None:
        if self._writer is not None:
            self._writer.release()


class _Gif:
    """An endless gif. Pillow alone would hold all of its pictures until the last one is known."""

    def __init__(self, file: IO[bytes], rate: float) -> None:
        self._file = file
        self._ticks = max(round(1 / (rate * _GIF_TICK)), 2)
        self._empty = True

    def add(self, picture: np.ndarray) -> None:
        from PIL import GifImagePlugin, Image

        # Each picture brings colours of its own: what moves is not drawn in those of the first. Maximum
        # coverage keeps rare ones, those of a colour bar, where the median cut spends most on greys.
        most = Image.Quantize.MAXCOVERAGE
        image = Image.fromarray(picture).quantize(_GIF_COLOURS, most, dither=Image.Dither.NONE)
        if self._empty:
            header, _ = GifImagePlugin.getheader(image, info={"loop": 0, "version": b"89a"})
            self._write(header)
            self._empty = False
        options: Any = {"duration": 10 * self._ticks, "include_color_table": True}
        self._write(GifImagePlugin.getdata(image, **options))

    def finish(self) -> None:
        self._file.write(b";")

    def _write(self, parts: list[bytes]) -> None:
        for part in parts:
            self._file.write(part)
