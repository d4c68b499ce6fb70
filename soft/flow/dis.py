"""Dense inverse search (Kroeger, Timofte, Dai, Van Gool, ECCV 2016), as OpenCV has it.

OpenCV's DIS takes 8-bit pictures: `to_8bit` says what that loses. It knows no mask, so pixels beside a masked
region are measured with that region's texture.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from soft.flow.estimator import Estimator
from soft.flow.field import FlowError, FlowField
from soft.flow.opencv import to_8bit
from soft.flow.options import require_choice, require_count, require_flag, require_number

# Options of ours and the setters of OpenCV's class behind them.
_SETTERS = {
    "finest_scale": "FinestScale",
    "coarsest_scale": "CoarsestScale",
    "patch_size": "PatchSize",
    "patch_stride": "PatchStride",
    "gradient_descent_iterations": "GradientDescentIterations",
    "variational_refinement_iterations": "VariationalRefinementIterations",
    "variational_refinement_alpha": "VariationalRefinementAlpha",
    "variational_refinement_delta": "VariationalRefinementDelta",
    "variational_refinement_gamma": "VariationalRefinementGamma",
    "use_mean_normalization": "UseMeanNormalization",
    "use_spatial_propagation": "UseSpatialPropagation",
}
PRESETS = ("ultrafast", "fast", "medium")


@dataclass(frozen=True)
class DisOptions:
    """A preset and what differs from it; None keeps the preset's value.

    `finest_scale` is the pyramid level the flow is measured on (0 = full resolution, 1 = half),
    `coarsest_scale` the one it starts from (None: chosen from the picture size). Patch sizes are px of that
    level.
    """

    preset: str = "medium"
    finest_scale: int | None = None
    coarsest_scale: int | None = None
    patch_size: int | None = None
    patch_stride: int | None = None
    gradient_descent_iterations: int | None = None
    variational_refinement_iterations: int | None = None
    variational_refinement_alpha: float | None = None
    variational_refinement_delta: float | None = None
    variational_refinement_gamma: float | None = None
    use_mean_normalization: bool | None = None
    use_spatial_propagation: bool | None = None

    def __post_init__(self) -> None:
        require_choice("preset", self.preset, PRESETS)
        for name in _SETTERS:
            if (value := getattr(self, name)) is not None:
                _check_option(name, value)


def _check_option(name: str, value: object) -> None:
    if name.startswith("use_"):
        require_flag(name, value)
    elif name.startswith("patch_"):
        require_count(name, value, least=1, most=64)
    elif name.endswith("_scale"):
        require_count(name, value, least=0, most=10)
    elif name.endswith("_iterations"):
        require_count(name, value, least=0, most=10_000)
    else:
        require_number(name, value, above=0.0)


def _solver(options: DisOptions) -> Any:
    import cv2

    presets = (
        cv2.DISOPTICAL_FLOW_PRESET_ULTRAFAST,
        cv2.DISOPTICAL_FLOW_PRESET_FAST,
        cv2.DISOPTICAL_FLOW_PRESET_MEDIUM,
    )
    solver = cv2.DISOpticalFlow.create(presets[PRESETS.index(options.preset)])
    for name, setter in _SETTERS.items():
        if (value := getattr(options, name)) is not None:
            getattr(solver, f"set{setter}")(value)
    return solver


def _require_pyramid_fits(solver: Any, shape: tuple[int, int]) -> None:
    """Refuse pictures with a level that is smaller than a patch: OpenCV 5.0 crashes on some of them."""
    finest, coarsest, patch = solver.getFinestScale(), solver.getCoarsestScale(), solver.getPatchSize()
    if 0 <= coarsest < finest:
        raise FlowError(f"coarsest_scale: {coarsest}: must be at least finest_scale, which is {finest}")
    least = patch * 2 ** max(finest, coarsest)
    if min(shape) < least:
        raise FlowError(
            f"pictures of {shape[1]} x {shape[0]} px: dis with patch_size {patch}, finest_scale {finest} and "
            f"coarsest_scale {coarsest if coarsest >= 0 else 'automatic'} needs at least {least} px each way"
        )


def _solve(first: np.ndarray, second: np.ndarray, mask: np.ndarray, options: DisOptions) -> FlowField:
    solver = _solver(options)
    _require_pyramid_fits(solver, (first.shape[0], first.shape[1]))
    displacement = solver.calc(to_8bit(first), to_8bit(second), None)
    return FlowField(displacement, mask)


def _resolved(options: DisOptions) -> dict[str, object]:
    solver = _solver(options)
    told: dict[str, object] = {name: getattr(solver, f"get{setter}")() for name, setter in _SETTERS.items()}
    # OpenCV says -1 where it chooses from the picture size.
    return {"preset": options.preset} | told | {"coarsest_scale": options.coarsest_scale}


def _effective_window(options: DisOptions) -> float:
    """A patch, in px of the pictures."""
    solver = _solver(options)
    return solver.getPatchSize() * 2.0 ** solver.getFinestScale()


ESTIMATOR = Estimator("dis", DisOptions, _solve, resolved=_resolved, effective_window=_effective_window)
