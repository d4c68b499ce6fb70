"""TV-L1 (Zach, Pock, Bischof 2007; Wedel et al. 2009), as scikit-image has it.

It knows no mask, so pixels beside a masked region are measured with that region's texture.
"""

from dataclasses import dataclass

import numpy as np

from soft.flow.estimator import Estimator
from soft.flow.field import FlowField
from soft.flow.options import require_count, require_flag, require_number
from soft.flow.skimage import registration, to_displacement, to_unit

_WINDOW = 7.0
"""It has no window: px over which total variation was taken to average, for the uncertainty alone."""


@dataclass(frozen=True)
class Tvl1Options:
    """scikit-image's parameters under plain names.

    The smaller `attachment`, the smoother the motion; `tightness` couples the parts that hold on to the
    pictures and that smooth. `warp_count` warps a level and `iteration_count` iterations a warp, which end
    early when motion changes by less than `tolerance`; `prefilter` takes a 3 x 3 median before each warp.
    """

    attachment: float = 15.0
    tightness: float = 0.3
    warp_count: int = 5
    iteration_count: int = 10
    tolerance: float = 1e-4
    prefilter: bool = False

    def __post_init__(self) -> None:
        require_number("attachment", self.attachment, above=0.0)
        require_number("tightness", self.tightness, above=0.0)
        require_count("warp_count", self.warp_count, least=1, most=1000)
        require_count("iteration_count", self.iteration_count, least=1, most=10_000)
        require_number("tolerance", self.tolerance, above=0.0)
        require_flag("prefilter", self.prefilter)


def _solve(first: np.ndarray, second: np.ndarray, mask: np.ndarray, options: Tvl1Options) -> FlowField:
    flow = registration("tvl1").optical_flow_tvl1(
        to_unit(first),
        to_unit(second),
        attachment=options.attachment,
        tightness=options.tightness,
        num_warp=options.warp_count,
        num_iter=options.iteration_count,
        tol=options.tolerance,
        prefilter=options.prefilter,
    )
    return FlowField(to_displacement(flow), mask)


ESTIMATOR = Estimator("tvl1", Tvl1Options, _solve, least_side=16, effective_window=lambda _: _WINDOW)
