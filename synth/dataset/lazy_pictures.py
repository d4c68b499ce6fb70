"""Pictures of footage as an array of xarray's that reads a picture when it is used."""

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from xarray.backends import BackendArray
from xarray.core import indexing

if TYPE_CHECKING:
    from synth.footage import Footage


def lazy_pictures(footage: "Footage") -> xr.Variable:
    """Grey levels over `frame, y, x`."""
    lazy = indexing.LazilyIndexedArray(_Pictures(footage))
    about = {"units": "1", "long_name": "grey level"}
    return xr.Variable(("frame", "y", "x"), lazy, about)


class _Pictures(BackendArray):
    """The least that xarray asks of an array on disk: its shape, and outer indexing."""

    def __init__(self, footage: "Footage") -> None:
        first = footage.picture(0)
        self._footage = footage
        self.shape = (footage.frame_count, *first.shape)
        self.dtype = first.dtype

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.BASIC, self._read)

    def _read(self, key: tuple[Any, ...]) -> np.ndarray:
        frames, *inside = key
        if isinstance(frames, int | np.integer):
            return self._footage.picture(int(frames))[tuple(inside)]
        chosen = range(self.shape[0])[frames]
        shown = [self._footage.picture(frame)[tuple(inside)] for frame in chosen]
        return (
            np.stack(shown) if shown else np.empty((0, *self.shape[1:]), self.dtype)[(slice(None), *inside)]
        )
