"""Flow that has been measured, kept on disk until an analysis is whole, so that a stopped one can go on."""

import hashlib
import json
import os
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from soft.flow import FlowField

_ARRAYS = ("displacement", "uncertainty", "nodes")


@dataclass(frozen=True, eq=False)
class MeasuredFlow:
    """Flow of one pair, and the seconds it took."""

    field: FlowField
    seconds: float


@dataclass(frozen=True)
class FlowStore:
    """A folder with a file for each pair, named by a hash of all that the flow depends on.

    A changed picture or setting has another hash: what was kept of it is not found, and measured anew. A file
    gets its name only when it is whole; one that is damaged counts as not there.

    Attributes
    ----------
    folder : Path
        Made when the first pair is kept. Whoever gave it removes it.
    """

    folder: Path

    def find(self, key: str) -> MeasuredFlow | None:
        """Read what was kept under a key; None where that is nothing, or nothing whole."""
        try:
            with np.load(self._path(key), allow_pickle=False) as kept:
                arrays = {name: kept[name] for name in _ARRAYS if name in kept}
                seconds = float(kept["seconds"])
        except (OSError, EOFError, ValueError, KeyError, zipfile.BadZipFile, zlib.error):
            return None
        # The displacement is finite exactly where it is valid.
        valid = np.isfinite(arrays["displacement"]).all(axis=2)
        return MeasuredFlow(FlowField(valid=valid, **arrays), seconds)

    def keep(self, key: str, flow: MeasuredFlow) -> None:
        """Write a pair's flow; its gradient, which no result holds, is left out."""
        self.folder.mkdir(parents=True, exist_ok=True)
        told = {name: getattr(flow.field, name) for name in _ARRAYS}
        arrays = {name: array for name, array in told.items() if array is not None}
        draft = self.folder / f"{key}.tmp"
        try:
            with draft.open("wb") as file:
                np.savez(file, seconds=flow.seconds, **arrays)
                file.flush()
                os.fsync(file.fileno())
            draft.replace(self._path(key))
        except OSError as error:  # of what cannot be written, the system does not name the file
            error.filename = error.filename or str(draft)
            raise
        finally:
            draft.unlink(missing_ok=True)  # a full disk gets its bytes back

    def _path(self, key: str) -> Path:
        return self.folder / f"{key}.npz"


def flow_key(settings: Mapping[str, object], *arrays: np.ndarray | None) -> str:
    """SHA-256 over settings (anything JSON can hold) and the bytes and shapes of arrays, hexadecimal."""
    digest = hashlib.sha256(json.dumps(settings, sort_keys=True).encode())
    for array in arrays:
        if array is None:
            digest.update(b"none")
            continue
        digest.update(f"{array.dtype.str} {array.shape}".encode())
        digest.update(np.ascontiguousarray(array).data)
    return digest.hexdigest()
