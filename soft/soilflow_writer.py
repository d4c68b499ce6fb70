"""Filling a SoilFlow pair by pair, in memory or in a file."""

import errno
import os
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from soft.soilflow import VariableSpec, check_soil_flow, coordinates_for, read_soil_flow, variables_for

if TYPE_CHECKING:
    import xarray

# A part of a picture that is read alone costs no more than this many px each way.
CHUNK_SIDE = 512

# Noise in the last digits does not compress: a higher level only takes longer.
COMPRESSION_LEVEL = 1

# Bytes that HDF5 may need for more than the values themselves, until a file is closed.
ROOM = 1 << 18


class SoilFlowWriter(Protocol):
    """Takes the arrays of one pair after the other."""

    def put(self, pair: int, values: Mapping[str, Any]) -> None:
        """Set variables of one pair; one that is not given stays unmeasured."""
        ...

    def finish(self, attributes: Mapping[str, object]) -> "xarray.Dataset":
        """Set the attributes and hand out the checked data set."""
        ...

    def abandon(self) -> None:
        """Let go of what is open after a failure."""
        ...


class MemoryWriter:
    """Holds the whole SoilFlow in memory."""

    def __init__(self, sizes: Mapping[str, int], *, calibrated: bool, gridded: bool, timed: bool) -> None:
        self._coordinates = coordinates_for(timed=timed)
        self._specs = variables_for(calibrated=calibrated, gridded=gridded) | self._coordinates
        self._arrays = {name: _empty(spec, sizes) for name, spec in self._specs.items()}

    def put(self, pair: int, values: Mapping[str, Any]) -> None:
        """Set variables of one pair."""
        for name, value in values.items():
            self._arrays[name][pair] = value

    def finish(self, attributes: Mapping[str, object]) -> "xarray.Dataset":
        """Make the data set of what was put."""
        import xarray

        variables = {
            name: (spec.dims, self._arrays[name], {"units": spec.units, "long_name": spec.long_name})
            for name, spec in self._specs.items()
        }
        flow = xarray.Dataset(variables, attrs=dict(attributes)).set_coords(list(self._coordinates))
        return check_soil_flow(flow)

    def abandon(self) -> None:
        """Nothing is open."""


class FileWriter:
    """Writes each pair to a netCDF-4 file as it comes, so that memory holds one pair at a time."""

    def __init__(
        self, path: str | Path, sizes: Mapping[str, int], *, calibrated: bool, gridded: bool, timed: bool
    ) -> None:
        import h5netcdf

        self._path = Path(path)
        self._require_space(0)
        self._file = h5netcdf.File(self._path, "w")
        self._file.dimensions = dict(sizes)
        coordinates = coordinates_for(timed=timed)
        for name, spec in (variables_for(calibrated=calibrated, gridded=gridded) | coordinates).items():
            self._create(name, spec, sizes, is_pixel_data=name not in coordinates)

    def _create(
        self, name: str, spec: VariableSpec, sizes: Mapping[str, int], *, is_pixel_data: bool
    ) -> None:
        dtype = np.dtype(spec.dtype)
        is_bool = dtype.kind == "b"
        images = len(spec.dims) == 3
        variable = self._file.create_variable(
            name,
            spec.dims,
            # netCDF has no bool: xarray's way is a byte that says so.
            dtype="i1" if is_bool else dtype,
            fillvalue=np.array(np.nan, dtype)[()] if dtype.kind == "f" else None,
            **(_chunked(spec, sizes) if images else {}),
        )
        variable.attrs["units"] = spec.units
        variable.attrs["long_name"] = spec.long_name
        if is_bool:
            variable.attrs["dtype"] = "bool"
        if is_pixel_data:
            variable.attrs["coordinates"] = "first_frame second_frame time"

    def put(self, pair: int, values: Mapping[str, Any]) -> None:
        """Write variables of one pair."""
        stored = {n: np.asarray(value).astype(self._file.variables[n].dtype) for n, value in values.items()}
        self._require_space(sum(array.nbytes for array in stored.values()))
        for name, array in stored.items():
            self._file.variables[name][pair] = array

    def _require_space(self, size: int) -> None:
        """Raise what the system would: HDF5 does not survive that it cannot write, nor does the process."""
        if shutil.disk_usage(self._path.parent).free < size + ROOM:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(self._path))

    def finish(self, attributes: Mapping[str, object]) -> "xarray.Dataset":
        """Close the file and open it for reading."""
        for name, value in attributes.items():
            self._file.attrs[name] = value
        self._file.close()
        return read_soil_flow(self._path)

    def abandon(self) -> None:
        """Close the file; whoever gave the path removes it."""
        self._file.close()


def _empty(spec: VariableSpec, sizes: Mapping[str, int]) -> np.ndarray:
    dtype = np.dtype(spec.dtype)
    return np.full([sizes[dim] for dim in spec.dims], np.nan if dtype.kind == "f" else 0, dtype)


def _chunked(spec: VariableSpec, sizes: Mapping[str, int]) -> dict[str, object]:
    chunks = tuple(1 if dim == "pair" else min(sizes[dim], CHUNK_SIDE) for dim in spec.dims)
    return {"chunks": chunks, "compression": "gzip", "compression_opts": COMPRESSION_LEVEL, "shuffle": True}
