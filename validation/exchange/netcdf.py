"""CF netCDF-4: the pictures, and motion with what is told about it."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.exchange.field import Field

if TYPE_CHECKING:
    import xarray as xr

    from soft import ImageSequence

_CONVENTIONS = "CF-1.11"


def write(
    fields: Sequence[Field], sequence: "ImageSequence", folder: Path, advance: Callable[[], None]
) -> None:
    """Write `pictures.nc` and `<field>.nc`; `advance` is called after each pair."""
    _write_pictures(sequence, folder / "pictures.nc")
    for field in fields:
        _write_field(field, sequence, folder / f"{field.name}.nc", advance)


def _write_field(field: Field, sequence: "ImageSequence", path: Path, advance: Callable[[], None]) -> None:
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
            advance()


def _write_pictures(sequence: "ImageSequence", path: Path) -> None:
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
