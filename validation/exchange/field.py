"""One source of motion."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray as xr


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
        return self.vectors(pair, "u", "v")

    def vectors(self, pair: int, first: str, second: str) -> np.ndarray:
        """Two variables of one pair as vectors, (H, W, 2) float32; NaN where motion is not known."""
        chosen = self.data[[first, second, "valid"]].isel(pair=pair)
        values = np.stack([chosen[first].values, chosen[second].values], axis=-1).astype(np.float32)
        values[~chosen["valid"].values.astype(bool)] = np.nan
        return values

    def nodes(self, pair: int) -> np.ndarray | None:
        """Where a grid's vectors were measured, (H, W, 2) px, NaN without one; None: at every pixel."""
        if "node_x" not in self.data:
            return None
        chosen = self.data[["node_x", "node_y"]].isel(pair=pair)
        return np.stack([chosen["node_x"].values, chosen["node_y"].values], axis=-1)
