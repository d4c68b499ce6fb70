"""Versions of what can change a number of a data set."""

import platform
from importlib import metadata

DECISIVE = ("softbed", "numpy", "scipy", "taichi", "opencv-python-headless")
"""Packages whose numbers a data set is made of: all of it by the same versions."""
_RECORDED = ("xarray", "h5netcdf", "h5py", "pydantic", "isal", "dask", "distributed")


def decisive_versions() -> dict[str, str]:
    """Version of each of `DECISIVE`."""
    return {name: metadata.version(name) for name in DECISIVE}


def all_versions() -> dict[str, str]:
    """Version of Python, of these, and of what reads, writes and distributes."""
    recorded = {name: _version(name) for name in _RECORDED}
    return {"python": platform.python_version(), **decisive_versions(), **recorded}


def differing(ours: dict[str, str], theirs: dict[str, str]) -> str | None:
    """Say in words which version differs first; None where none does."""
    for name in DECISIVE:
        if ours.get(name) != theirs.get(name):
            return f"{name} {theirs.get(name)}, here is {ours.get(name)}"
    return None


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "not installed"
