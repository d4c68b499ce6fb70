"""A measurement's file: classic netCDF.

A measurement has forty small variables. To write or read them as netCDF-4 takes thirty times as long.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

_ENGINE: Final = "scipy"


def write_measurement(found: "xr.Dataset", path: Path) -> None:
    """Write a measurement; its attribute `key` says of what it is."""
    # Classic netCDF has no unsigned numbers.
    unsigned = {name: one.astype(np.int32) for name, one in found.data_vars.items() if one.dtype.kind == "u"}
    found.assign(unsigned).to_netcdf(path, engine=_ENGINE, format="NETCDF3_64BIT")


def read_measurement(path: Path) -> "xr.Dataset":
    """Read a measurement into memory; counts are as wide as they were, so that many may be added up."""
    import xarray as xr

    found = xr.load_dataset(path, engine=_ENGINE)
    counts = {name: one.astype(np.int64) for name, one in found.data_vars.items() if one.dtype.kind == "i"}
    return found.assign(counts)


def open_measurement(path: Path) -> "xr.Dataset":
    """Open a measurement, of which only little is wanted; to be closed."""
    import xarray as xr

    return xr.open_dataset(path, engine=_ENGINE)


def key_in(path: Path) -> str | None:
    """What a measurement says that it was made of; None where there is no file, or it is not whole."""
    from scipy.io import netcdf_file

    try:
        with netcdf_file(path, mmap=True) as file:
            return str(file.key.decode())
    except (OSError, ValueError, TypeError, KeyError, IndexError, AttributeError):
        return None
