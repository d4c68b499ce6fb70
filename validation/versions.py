"""What made a result: package versions and the machine."""

import os
import platform
from importlib import metadata
from pathlib import Path

# The packages whose version can change a number.
PACKAGES = (
    "softbed",
    "numpy",
    "scipy",
    "opencv-python-headless",
    "scikit-learn",
    "taichi",
    "xarray",
    "h5netcdf",
    "h5py",
    "pydantic",
)


def package_version(name: str) -> str:
    """Version of an installed distribution, `"not installed"` where there is none."""
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "not installed"


def package_versions() -> dict[str, str]:
    """Version of Python and of every package that can change a number."""
    return {"python": platform.python_version(), **{name: package_version(name) for name in PACKAGES}}


def machine() -> dict[str, str | int]:
    """Processor, its number of cores, and operating system; nothing that names the computer or its user."""
    return {
        "cpu": _processor(),
        "cores": os.cpu_count() or 1,
        "architecture": platform.machine(),
        "system": f"{platform.system()} {platform.release()}",
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor())
