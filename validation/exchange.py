"""Truth and measured fields in the formats of other programs.

Every format gets a folder of its own, `OUT/<format>/`, with a part for the truth and for each method. Where a
motion is not known or was not measured, formats that can say so do; CSV leaves the pixel out.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

    from soft import ImageSequence

FORMATS = {
    "flo": "Middlebury, float32",
    "kitti": "KITTI, 16-bit PNG, rounded to 1/64 px",
    "netcdf": "CF netCDF-4, float32, pictures too",
    "csv": "x, y, u, v; a line for each pixel whose motion is known",
    "mp4": "for looking at only: pictures, and motion in colours",
}

_CONVENTIONS = "CF-1.11"
_TOP_PERCENTILE = 99.5
_CODEC = "mp4v"  # MPEG-4 part 2: the one that every wheel of OpenCV can write into .mp4
_SLOWEST_VIDEO, _FASTEST_VIDEO = 1.0, 60.0

Progress = Callable[[int, int], None]


@dataclass(frozen=True, eq=False)
class Field:
    """One source of motion.

    Attributes
    ----------
    name : str
        `truth`, or a method's name as files have it.
    data : xarray.Dataset
        Over `pair, y, x`: `u`, `v` (px) and `valid`.
    """

    name: str
    data: "xr.Dataset"

    @property
    def pair_count(self) -> int:
        """Number of picture pairs."""
        return int(self.data.sizes["pair"])

    def displacement(self, pair: int) -> np.ndarray:
        """Motion of one pair, (H, W, 2) float32 px; NaN where it is not known."""
        chosen = self.data[["u", "v", "valid"]].isel(pair=pair)
        values = np.stack([chosen["u"].values, chosen["v"].values], axis=-1).astype(np.float32)
        values[~chosen["valid"].values.astype(bool)] = np.nan
        return values


def write_fields(
    fields: Sequence[Field],
    sequence: "ImageSequence",
    file_format: str,
    folder: Path,
    *,
    progress: Progress | None = None,
) -> None:
    """Write fields in one of `FORMATS`.

    Parameters
    ----------
    fields : sequence of Field
    sequence : soft.ImageSequence
        The pictures they are of.
    file_format : str
        A key of `FORMATS`.
    folder : Path
        Where to; must exist.
    progress : callable, optional
        Called with the pairs done and the pairs in all.

    Raises
    ------
    soft.FlowError
        A displacement that the format cannot hold.
    """
    steps = _Steps(sum(field.pair_count for field in fields), progress)
    if file_format == "netcdf":
        _write_pictures_netcdf(sequence, folder / "pictures.nc")
        for field in fields:
            _write_netcdf(field, sequence, folder / f"{field.name}.nc", steps)
    elif file_format == "mp4":
        _write_videos(fields, sequence, folder, steps)
    else:
        suffix, write = _PAIR_WRITERS[file_format]
        for field in fields:
            (folder / field.name).mkdir()
            for pair in range(field.pair_count):
                write(folder / field.name / f"{pair:06d}{suffix}", field.displacement(pair))
                steps.advance()


class _Steps:
    """Counts pairs over all fields."""

    def __init__(self, total: int, progress: Progress | None) -> None:
        self._done, self._total, self._progress = 0, total, progress

    def advance(self) -> None:
        self._done += 1
        if self._progress is not None:
            self._progress(self._done, self._total)


def _write_flo(path: Path, displacement: np.ndarray) -> None:
    from soft import write_flo

    write_flo(path, displacement)


def _write_kitti(path: Path, displacement: np.ndarray) -> None:
    from soft import write_kitti

    write_kitti(path, displacement)


def _write_csv(path: Path, displacement: np.ndarray) -> None:
    """Write a line a pixel; nine digits tell every float32 from its neighbours."""
    rows, columns = np.nonzero(np.isfinite(displacement).all(axis=2))
    u, v = displacement[rows, columns].astype(np.float64).T
    header = "x [px],y [px],u [px],v [px]"
    np.savetxt(path, np.column_stack([columns, rows, u, v]), "%d,%d,%.9g,%.9g", header=header, comments="")


_PAIR_WRITERS: dict[str, tuple[str, Callable[[Path, np.ndarray], None]]] = {
    "flo": (".flo", _write_flo),
    "kitti": (".png", _write_kitti),
    "csv": (".csv", _write_csv),
}


def _write_netcdf(field: Field, sequence: "ImageSequence", path: Path, steps: _Steps) -> None:
    import h5netcdf

    height, width = sequence.shape
    names = ["u", "v", *(name for name in ("uncertainty_u", "uncertainty_v") if name in field.data)]
    with h5netcdf.File(path, "w") as file:
        file.attrs.update(_attributes(sequence, f"motion: {field.name}"))
        file.dimensions = {"pair": field.pair_count, "y": height, "x": width}
        _write_axes(file, height, width)
        for name in ("first_frame", "second_frame", "time"):
            _variable(file, name, ("pair",), field.data[name])[...] = field.data[name].values
        for name in names:
            _variable(file, name, ("pair", "y", "x"), field.data[name], np.float32)
        valid = _variable(file, "valid", ("pair", "y", "x"), field.data["valid"], np.int8)
        valid.attrs["dtype"] = "bool"  # netCDF has none: xarray reads it back as one
        for pair in range(field.pair_count):
            chosen = field.data[[*names, "valid"]].isel(pair=pair)
            for name in (*names, "valid"):
                variable = file.variables[name]
                variable[pair] = chosen[name].values.astype(variable.dtype)
            steps.advance()


def _write_pictures_netcdf(sequence: "ImageSequence", path: Path) -> None:
    """Write grey levels of 0-255, as they are measured in: integers where they are whole."""
    import h5netcdf

    height, width = sequence.shape
    with h5netcdf.File(path, "w") as file:
        file.attrs.update(_attributes(sequence, "pictures"))
        file.dimensions = {"frame": len(sequence), "y": height, "x": width}
        _write_axes(file, height, width)
        first = sequence[0]
        dtype = np.uint8 if np.array_equal(first, np.rint(first)) else np.float32
        picture = file.create_variable("picture", ("frame", "y", "x"), dtype, **_chunks(height, width))
        picture.attrs.update({"units": "1", "long_name": "grey level, 0 black to 255 white"})
        for frame in range(len(sequence)):
            picture[frame] = sequence[frame].astype(dtype)


def _write_axes(file: Any, height: int, width: int) -> None:
    for name, count, meaning in (("y", height, "row, downwards"), ("x", width, "column, to the right")):
        axis = file.create_variable(name, (name,), data=np.arange(count, dtype=np.int32))
        axis.attrs.update({"units": "px", "long_name": f"{meaning}, of the pixel's centre"})


def _variable(
    file: Any, name: str, dims: tuple[str, ...], source: "xr.DataArray", dtype: type | None = None
) -> Any:
    storage = _chunks(*source.shape[-2:]) if len(dims) == 3 else {}
    variable = file.create_variable(name, dims, dtype or source.dtype, **storage)
    variable.attrs.update({key: source.attrs[key] for key in ("units", "long_name")})
    if len(dims) == 3:
        variable.attrs["coordinates"] = "first_frame second_frame time"
    return variable


def _chunks(height: int, width: int) -> dict[str, Any]:
    return {"chunks": (1, height, width), "compression": "gzip", "compression_opts": 1, "shuffle": True}


def _attributes(sequence: "ImageSequence", title: str) -> dict[str, Any]:
    told = {"Conventions": _CONVENTIONS, "title": title}
    told["comment"] = "x right, y down, integer at pixel centres; displacements forward, on the first frame"
    for name in ("metres_per_pixel", "frame_rate"):
        if (value := getattr(sequence, name)) is not None:
            told[name] = value
    return told


def _write_videos(fields: Sequence[Field], sequence: "ImageSequence", folder: Path, steps: _Steps) -> None:
    rate = float(np.clip(sequence.frame_rate or 8.0, _SLOWEST_VIDEO, _FASTEST_VIDEO))
    grey = (np.rint(sequence[frame]).astype(np.uint8) for frame in range(len(sequence)))
    _write_video(folder / "pictures.mp4", (np.dstack([frame] * 3) for frame in grey), rate)
    top = max((_top_speed(field) for field in fields), default=1.0)
    for field in fields:
        _write_video(folder / f"{field.name}.mp4", _coloured(field, top, steps), rate)


def _coloured(field: Field, top: float, steps: _Steps) -> Any:
    for pair in range(field.pair_count):
        yield motion_colours(field.displacement(pair), top=top)
        steps.advance()


def _write_video(path: Path, frames: Any, rate: float) -> None:
    """Write pictures (H, W, 3) uint8, blue, green, red; an odd last row or column is left out."""
    import cv2

    writer = None
    for frame in frames:
        even = np.ascontiguousarray(frame[: frame.shape[0] // 2 * 2, : frame.shape[1] // 2 * 2])
        if writer is None:
            size = even.shape[1], even.shape[0]
            writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*_CODEC), rate, size)
            if not writer.isOpened():
                raise ValueError(f"{path}: this OpenCV cannot write mp4 with the codec {_CODEC}")
        writer.write(even)
    if writer is not None:
        writer.release()


def motion_colours(displacement: np.ndarray, *, top: float) -> np.ndarray:
    """Direction as hue, speed as brightness up to `top` px: (H, W, 3) uint8, blue, green, red.

    Right is red, down is green-yellow, left is cyan, up is violet; grey is unknown.
    """
    import cv2

    known = np.isfinite(displacement).all(axis=2)
    u, v = np.moveaxis(np.where(known[:, :, None], displacement, 0).astype(np.float64), -1, 0)
    hue = np.rint(np.mod(np.arctan2(v, u), 2 * np.pi) * 90 / np.pi) % 180
    value = 255 * np.minimum(np.hypot(u, v) / top, 1)
    colours = np.dstack([hue, np.full(u.shape, 255.0), np.rint(value)]).astype(np.uint8)
    picture = cv2.cvtColor(colours, cv2.COLOR_HSV2BGR)
    picture[~known] = 96
    return picture


def _top_speed(field: Field) -> float:
    speed = np.hypot(*np.moveaxis(field.displacement(0), -1, 0))
    known = speed[np.isfinite(speed)]
    return max(float(np.percentile(known, _TOP_PERCENTILE)), 0.1) if known.size else 0.1
