"""What one pair of a SoilFlow says of soil's own motion."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from soft.between_nodes import between_nodes

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, eq=False)
class PairMotion:
    """Inertial motion of the soil in one picture pair.

    Attributes
    ----------
    displacement : (H, W, 2) float32
        Inertial (u, v) in px, x right and y down; NaN where there is no soil, or it was not measured.
    soil, moving : (H, W) bool
        Where soil is, and where it moves.
    spacing : float
        Px between the nodes of a grid that `displacement` is linear between; 0 where each is measured itself.
    """

    displacement: np.ndarray
    soil: np.ndarray
    moving: np.ndarray
    spacing: float = 0.0

    @property
    def measured(self) -> np.ndarray:
        """(H, W) bool: soil whose motion was measured."""
        return np.isfinite(self.displacement[:, :, 0])

    @property
    def speed(self) -> np.ndarray:
        """(H, W) float32: magnitude of the displacement, px."""
        return np.hypot(self.displacement[:, :, 0], self.displacement[:, :, 1])


def motion_of_pair(flow: "xarray.Dataset", pair: int = 0) -> PairMotion:
    """Read one pair of a SoilFlow; negative ones count from the end.

    Raises
    ------
    IndexError
        If there is no such pair.
    """
    part = flow[["inertial_u", "inertial_v", "valid", "soil", "moving"]].isel(pair=pair).load()
    soil, moving, valid = (part[name].to_numpy().astype(bool) for name in ("soil", "moving", "valid"))
    displacement = np.stack([part["inertial_u"].to_numpy(), part["inertial_v"].to_numpy()], axis=-1)
    displacement[~(soil & valid & np.isfinite(displacement).all(axis=2))] = np.nan
    return PairMotion(displacement, soil, moving)


def motion_between_nodes(flow: "xarray.Dataset", pair: int = 0) -> PairMotion:
    """Read one pair as `motion_of_pair` does; that of a grid is taken as linear between its nodes.

    A boundary, a streamline or a gradient needs motion at neighbouring pixels, which a grid does not tell.
    """
    motion = motion_of_pair(flow, pair)
    if "node_x" not in flow:
        return motion
    part = flow[["node_x", "node_y"]].isel(pair=pair)
    nodes = np.stack([part["node_x"].to_numpy(), part["node_y"].to_numpy()], axis=-1)
    filled = between_nodes(motion.displacement, nodes, motion.soil)
    return replace(motion, displacement=filled.displacement, spacing=filled.spacing)
