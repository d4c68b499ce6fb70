"""Footage on disk: pictures, what is needed to measure in them, and the truth about their motion."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from synth.disk import is_inside
from synth.png import png_bytes
from synth.text_files import read_toml

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

SCHEMA_VERSION = 1
_KEYS = {"schema_version", "frame_rate", "metres_per_pixel", "frames"}


def frame_name(frame: int) -> str:
    """Path of a frame's picture within the footage folder."""
    return f"frames/{frame:06d}.png"


def write_sequence(folder: Path, frame_rate: float, metres_per_pixel: float, frame_count: int) -> None:
    """Write `sequence.toml`: all that the analysis reads besides the pictures."""
    import tomli_w

    tables = {
        "schema_version": SCHEMA_VERSION,
        "frame_rate": frame_rate,
        "metres_per_pixel": metres_per_pixel,
        "frames": [frame_name(frame) for frame in range(frame_count)],
    }
    (folder / "sequence.toml").write_text(tomli_w.dumps(tables), encoding="utf-8")


def write_picture(path: Path, picture: "np.ndarray") -> None:
    """Write a grey picture as PNG, without loss."""
    path.write_bytes(png_bytes(picture))


@dataclass(frozen=True)
class Footage:
    """Pictures and truth of a folder; only what is asked for is read. Close it, or use it in a `with`.

    Attributes
    ----------
    folder : Path
    frame_rate : float
        1/s.
    metres_per_pixel : float
    frames : tuple of Path
        The pictures.
    """

    folder: Path
    frame_rate: float
    metres_per_pixel: float
    frames: tuple[Path, ...]
    _truth: "xr.Dataset" = field(repr=False)

    @classmethod
    def open(cls, folder: str | Path) -> Self:
        """Open a footage folder and check that it is whole.

        Raises
        ------
        ValueError
            With the file and what is wrong with it.
        """
        folder = Path(folder)
        tables = _read_sequence(folder / "sequence.toml")
        frames = tuple(folder / name for name in tables["frames"])
        for path in frames:
            if not path.is_file():
                raise ValueError(f"{path}: named in sequence.toml, but there is no such file")
        truth = _open_truth(folder / "truth.nc", len(frames))
        try:
            _check_size(read_picture(frames[0]), frames[0], truth)
        except ValueError:
            truth.close()
            raise
        return cls(folder, float(tables["frame_rate"]), float(tables["metres_per_pixel"]), frames, truth)

    @property
    def frame_count(self) -> int:
        """Number of pictures."""
        return len(self.frames)

    @property
    def pair_count(self) -> int:
        """Number of consecutive pairs, each with its truth."""
        return self.frame_count - 1

    @property
    def attributes(self) -> dict[str, Any]:
        """What `truth.nc` says of its origin: scene, scene hash, seed and more."""
        return dict(self._truth.attrs)

    @property
    def truths(self) -> "xr.Dataset":
        """Truth of all pairs, over pair, y and x; values are read when they are used. Not to be closed."""
        return self._truth

    @property
    def variables(self) -> "dict[str, xr.Variable]":
        """Every variable of `truth.nc`, coordinates too; values are read when they are used."""
        return {str(name): variable for name, variable in self._truth.variables.items()}

    def picture(self, frame: int) -> "np.ndarray":
        """Picture of a frame: (H, W) uint8 or uint16.

        Raises
        ------
        ValueError
            No such frame, or a picture that is unreadable, coloured or of another size.
        """
        path = self.frames[_checked(frame, self.frame_count, "frame")]
        picture = read_picture(path)
        _check_size(picture, path, self._truth)
        return picture

    def truth(self, pair: int) -> "xr.Dataset":
        """Truth of the pair (`pair`, `pair` + 1), in memory: the variables of `truth.nc` over y and x.

        Raises
        ------
        ValueError
            No such pair, or damaged data.
        """
        chosen = self._truth.isel(pair=_checked(pair, self.pair_count, "pair"))
        try:
            return chosen.load()
        except Exception as error:  # xarray raises whatever the damage leads to
            raise ValueError(f"{self.folder / 'truth.nc'}: pair {pair} is damaged: {error}") from None

    def close(self) -> None:
        """Close `truth.nc`."""
        self._truth.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _checked(index: int, count: int, what: str) -> int:
    if not 0 <= index < count:
        raise ValueError(f"{what} = {index}: allowed are 0 to {count - 1}")
    return index


def _read_sequence(path: Path) -> dict[str, Any]:
    try:
        tables = read_toml(path)
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror}") from None
    except ValueError as error:
        raise ValueError(f"{path}: not TOML: {error}") from None
    if set(tables) != _KEYS:
        raise ValueError(f"{path}: keys missing or unknown: {', '.join(sorted(set(tables) ^ _KEYS))}")
    if tables["schema_version"] != SCHEMA_VERSION:
        version = tables["schema_version"]
        raise ValueError(f"{path}: schema_version = {version!r}: this program reads {SCHEMA_VERSION}")
    for key in ("frame_rate", "metres_per_pixel"):
        if type(tables[key]) not in (int, float) or not 0 < tables[key] < float("inf"):
            raise ValueError(f"{path}: {key} = {tables[key]!r}: a positive number is needed")
    names = tables["frames"]
    if not isinstance(names, list) or len(names) < 2 or not all(isinstance(name, str) for name in names):
        raise ValueError(f"{path}: frames: a list of two or more file names is needed")
    for name in names:
        if not is_inside(name):
            raise ValueError(f"{path}: frames: {name!r}: must lie inside the folder")
    return tables


def _open_truth(path: Path, frame_count: int) -> "xr.Dataset":
    import xarray as xr

    from synth.truth import CAMERA_VARIABLES, VARIABLES
    from synth.truth import SCHEMA_VERSION as TRUTH_VERSION

    if not path.is_file():
        raise ValueError(f"{path}: no such file")
    try:
        truth = xr.open_dataset(path, engine="h5netcdf", decode_timedelta=False)
    except Exception as error:  # xarray raises whatever the damage leads to
        raise ValueError(f"{path}: not readable as netCDF-4: {error}") from None
    complaint = None
    if truth.attrs.get("schema_version") != TRUTH_VERSION:
        complaint = (
            f"schema_version = {truth.attrs.get('schema_version')}: this program reads {TRUTH_VERSION}"
        )
    elif missing := {*VARIABLES, *CAMERA_VARIABLES} - set(truth.data_vars):
        complaint = f"variables missing: {', '.join(sorted(missing))}"
    elif truth.sizes["pair"] != frame_count - 1:
        complaint = f"{truth.sizes['pair']} pairs for {frame_count} pictures: {frame_count - 1} are needed"
    if complaint:
        truth.close()
        raise ValueError(f"{path}: {complaint}")
    return truth


def read_picture(path: Path) -> "np.ndarray":
    """A grey picture of 8 or 16 bit, (H, W); raises ValueError where it is none."""
    import cv2
    import numpy as np

    picture = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if picture is None:
        raise ValueError(f"{path}: not readable as a picture")
    if picture.ndim != 2 or picture.dtype not in (np.uint8, np.uint16):
        raise ValueError(f"{path}: a grey picture of 8 or 16 bit is needed")
    return picture


def _check_size(picture: "np.ndarray", path: Path, truth: "xr.Dataset") -> None:
    needed = truth.sizes["y"], truth.sizes["x"]
    if picture.shape != needed:
        height, width = picture.shape
        raise ValueError(f"{path}: {width} x {height} px: truth.nc has {needed[1]} x {needed[0]}")
