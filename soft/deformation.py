"""How soil deforms: strain, shear, dilation, rotation, from the gradient of its displacement."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from soft.gradient import displacement_gradient
from soft.pair_motion import motion_between_nodes

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, eq=False)
class Deformation:
    """Parts of a displacement gradient, each (H, W) float32, a frame; NaN where the gradient was.

    Strains are small ones: rotations and strains of a frame are well below one. Times the frame rate they are
    rates in 1/s.

    Attributes
    ----------
    strain_xx, strain_yy, strain_xy : (H, W) float32
        Symmetric part of the gradient: du/dx, dv/dy, (du/dy + dv/dx) / 2, x right and y down.
    shear : (H, W) float32
        Equivalent shear strain, sqrt(2 e : e) of the deviator e: the amount of a simple shear, 0 where all
        sides stretch alike.
    dilation : (H, W) float32
        Divergence du/dx + dv/dy: growth of area, positive where soil loosens.
    rotation : (H, W) float32
        (dv/dx - du/dy) / 2 in radians: from right to down, clockwise in the picture, positive.
    """

    strain_xx: np.ndarray
    strain_yy: np.ndarray
    strain_xy: np.ndarray
    shear: np.ndarray
    dilation: np.ndarray
    rotation: np.ndarray

    @classmethod
    def from_gradient(cls, gradient: np.ndarray) -> "Deformation":
        """Split a displacement gradient into strain and rotation.

        Parameters
        ----------
        gradient : (H, W, 2, 2) array
            d(u, v)_i / d(x, y)_j at [.., i, j], as of `displacement_gradient`, or as `FlowField.gradient` has
            it.
        """
        strain_xx, strain_yy = gradient[..., 0, 0], gradient[..., 1, 1]
        strain_xy = (gradient[..., 0, 1] + gradient[..., 1, 0]) / 2
        rotation = (gradient[..., 1, 0] - gradient[..., 0, 1]) / 2
        # In the plane, 2 e : e is (xx - yy)^2 + (2 xy)^2.
        shear = np.hypot(strain_xx - strain_yy, 2 * strain_xy)
        parts = (strain_xx, strain_yy, strain_xy, shear, strain_xx + strain_yy, rotation)
        return cls(*(part.astype(np.float32) for part in parts))


def deformation_of(flow: "xarray.Dataset", *, pair: int = 0, scale: float = 3.0) -> Deformation:
    """Deformation of measured soil in one pair of a SoilFlow.

    Parameters
    ----------
    flow : xarray.Dataset
        A SoilFlow.
    pair : int, optional
        Which pair.
    scale : float, optional
        Px over which displacements are smoothed, as in `displacement_gradient`; of a grid half of what its
        nodes are apart, at least.
    """
    motion = motion_between_nodes(flow, pair)
    scale = max(scale, motion.spacing / 2)
    gradient = displacement_gradient(motion.displacement, motion.measured, scale=scale)
    return Deformation.from_gradient(gradient)
