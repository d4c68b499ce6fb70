"""Iterative Lucas-Kanade (Le Besnerais and Champagnat 2005), as scikit-image has it.

It knows no mask, so pixels beside a masked region are measured with that region's texture.
"""

from dataclasses import dataclass

import numpy as np

from soft.flow.estimator import Estimator
from soft.flow.field import FlowField
from soft.flow.options import require_count, require_flag
from soft.flow.skimage import registration, to_displacement, to_unit


@dataclass(frozen=True)
class IlkOptions:
    """scikit-image's parameters under plain names.

    Equations are averaged over `2 radius + 1` px each way, with a Gaussian if `gaussian_window`, else a box;
    `warp_count` warps a level, and `prefilter` takes a 3 x 3 median before each of them.
    """

    radius: int = 7
    warp_count: int = 10
    gaussian_window: bool = False
    prefilter: bool = False

    def __post_init__(self) -> None:
        require_count("radius", self.radius, least=1, most=500)
        require_count("warp_count", self.warp_count, least=1, most=1000)
        require_flag("gaussian_window", self.gaussian_window)
        require_flag("prefilter", self.prefilter)


def _solve(first: np.ndarray, second: np.ndarray, mask: np.ndarray, options: IlkOptions) -> FlowField:
    flow = registration("ilk").optical_flow_ilk(
        to_unit(first),
        to_unit(second),
        radius=options.radius,
        num_warp=options.warp_count,
        gaussian=options.gaussian_window,
        prefilter=options.prefilter,
    )
    return FlowField(to_displacement(flow), mask)


def _effective_window(options: IlkOptions) -> float:
    """The square whose mean varies as the window's; the Gaussian has a sigma of a quarter of its size."""
    side = 2 * options.radius + 1
    return side * (2 * np.sqrt(np.pi) / 4 if options.gaussian_window else 1.0)


ESTIMATOR = Estimator("ilk", IlkOptions, _solve, least_side=16, effective_window=_effective_window)
