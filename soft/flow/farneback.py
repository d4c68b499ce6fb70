"""Polynomial expansion (Farnebäck, SCIA 2003), as OpenCV has it.

OpenCV works on floats here, so nothing of a 16-bit picture is lost; but its equations carry a fixed small
number against division by zero, so at a contrast of a few grey levels displacements come out too small. It
knows no mask, so pixels beside a masked region are measured with that region's texture.
"""

from dataclasses import dataclass

import numpy as np

from soft.flow.estimator import Estimator
from soft.flow.field import FlowField
from soft.flow.options import require_count, require_flag, require_number


@dataclass(frozen=True)
class FarnebackOptions:
    """OpenCV's parameters under plain names.

    `pyramid_scale` is the size of a level over that of the finer one, `window_size` the px over which
    neighbours' equations are averaged (with a Gaussian if `gaussian_window`, else a box), `polynomial_size`
    the px of neighbourhood of the expansion and `polynomial_sigma` the width of its Gaussian weight in px.
    """

    pyramid_scale: float = 0.7
    level_count: int = 8
    window_size: int = 25
    iteration_count: int = 5
    polynomial_size: int = 5
    polynomial_sigma: float = 1.1
    gaussian_window: bool = True

    def __post_init__(self) -> None:
        require_number("pyramid_scale", self.pyramid_scale, above=0.0, below=1.0)
        require_count("level_count", self.level_count, least=1, most=20)
        require_count("window_size", self.window_size, least=3, most=1001)
        require_count("iteration_count", self.iteration_count, least=1, most=1000)
        require_count("polynomial_size", self.polynomial_size, least=3, most=15)
        require_number("polynomial_sigma", self.polynomial_sigma, above=0.0)
        require_flag("gaussian_window", self.gaussian_window)


def _solve(first: np.ndarray, second: np.ndarray, mask: np.ndarray, options: FarnebackOptions) -> FlowField:
    import cv2

    displacement = cv2.calcOpticalFlowFarneback(
        np.ascontiguousarray(first),
        np.ascontiguousarray(second),
        None,  # type: ignore[arg-type]  # OpenCV allocates
        options.pyramid_scale,
        options.level_count,
        options.window_size,
        options.iteration_count,
        options.polynomial_size,
        options.polynomial_sigma,
        cv2.OPTFLOW_FARNEBACK_GAUSSIAN if options.gaussian_window else 0,
    )
    return FlowField(displacement, mask)


def _effective_window(options: FarnebackOptions) -> float:
    """The square whose mean varies as the window's; OpenCV's Gaussian has a sigma of 0.15 of its size."""
    return options.window_size * (2 * np.sqrt(np.pi) * 0.15 if options.gaussian_window else 1.0)


ESTIMATOR = Estimator(
    "farneback", FarnebackOptions, _solve, least_side=16, effective_window=_effective_window
)
