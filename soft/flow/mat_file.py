"""What MATLAB's `.mat` files hold: of version 7 and older by SciPy, of version 7.3, which is HDF5, by h5py.

In HDF5 arrays lie with their axes in reverse, cells are references, and an empty array is told by its size.
"""

import functools
import pickle
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from soft.flow.field import FlowError

if TYPE_CHECKING:
    import h5py

_HDF5 = b"\x89HDF\r\n\x1a\n"
_ALONE = """
import pickle, sys
from scipy.io import loadmat
pickle.dump(loadmat(sys.argv[1]), sys.stdout.buffer)
"""
_USER_BLOCK = 512
"""Bytes of text that MATLAB puts before the HDF5 part."""


def read_mat(path: Path) -> dict[str, Any]:
    """Its variables by name: numeric arrays and, for cells, arrays of objects.

    Raises
    ------
    FlowError
        If it is no readable `.mat` file.
    """
    try:
        return _read_hdf5(path) if _is_hdf5(path) else _read_old(path)
    except Exception as error:  # both libraries raise whatever the damage leads to
        raise FlowError(f"{path}: not a readable .mat file: {error}") from error


def _is_hdf5(path: Path) -> bool:
    with path.open("rb") as file:
        start = file.read(_USER_BLOCK + len(_HDF5))
    return start.startswith(_HDF5) or start[_USER_BLOCK:].startswith(_HDF5)


def _read_old(path: Path) -> dict[str, Any]:
    about = path.stat()
    content = _read_alone(path.absolute(), about.st_size, about.st_mtime_ns)
    return {name: value for name, value in content.items() if not name.startswith("__")}


@functools.lru_cache(maxsize=2)
def _read_alone(path: Path, *_: int) -> dict[str, Any]:
    """Read a file in a process of its own: of changed bytes SciPy's reader can end the process that it is in.

    Kept, as each picture pair of a file asks for it again, until its size or time changes.
    """
    done = subprocess.run([sys.executable, "-c", _ALONE, str(path)], capture_output=True)
    if done.returncode < 0:
        raise ValueError(f"damaged: what reads it is ended by signal {-done.returncode}")
    if done.returncode:
        raise ValueError(done.stderr.decode(errors="replace").strip().rpartition("\n")[2])
    return pickle.loads(done.stdout)


def _read_hdf5(path: Path) -> dict[str, Any]:
    import h5py

    with h5py.File(path, "r") as file:
        sets = {name: held for name, held in file.items() if isinstance(held, h5py.Dataset)}
        return {name: _value(held, file) for name, held in sets.items()}


def _value(held: "h5py.Dataset", file: "h5py.File") -> np.ndarray:
    if held.attrs.get("MATLAB_empty", 0):
        return np.zeros(tuple(int(count) for count in held[()]))
    values = np.asarray(held[()])
    if values.dtype != object:
        return values.T
    cells = np.empty(values.size, object)
    for k, reference in enumerate(values.T.ravel()):
        cells[k] = _value(file[reference], file)
    return cells
