"""The estimator `black-anandan`: brightness constancy and smooth motion, both under robust penalties.

The energy (`energy.py`) is that of Black and Anandan (1996) as Sun, Roth, Lewis and Black (2008) and Sun,
Roth and Black (2010) write it. Its penalties go from quadratic to ever narrower Lorentzians in stages
(graduated non-convexity), each coarse to fine. At every level the second picture is warped by the present
motion several times; at each warp the equations are made linear, weighted by the penalties' slopes, and
solved (`system.py`). Written from the papers.
"""

from dataclasses import asdict, dataclass, replace

import numpy as np

from soft.devices import DEVICES, start_taichi
from soft.flow.black_anandan.energy import Energy
from soft.flow.black_anandan.median import filtered
from soft.flow.black_anandan.pyramid import LEAST_SIDE, Level, carried, extended, levels
from soft.flow.black_anandan.settings import PRESETS, Settings
from soft.flow.black_anandan.texture import texture
from soft.flow.black_anandan.uncertainty import standard_deviation
from soft.flow.coarse_search import better_of, common_shift, least_side, search
from soft.flow.estimator import Estimator
from soft.flow.field import FlowField
from soft.flow.opencv import to_8bit
from soft.flow.options import require_choice, require_count
from soft.flow.way_back import MISSES, way_back

_FINEST = 2
"""Level of the pyramid on which the coarse search ends that motion starts from."""
_MARGIN, _TEXTURE_MARGIN = 1, 4
"""Px along a mask's edge that are not used: slopes reach over it, and a picture's texture further."""


@dataclass(frozen=True)
class BlackAnandanOptions:
    """`accurate` is for use; `soft-2014` runs what the soil optical flow technique's paper tells of its own.

    `warp_count` as in `Settings`; None keeps the preset's.
    """

    preset: str = "accurate"
    warp_count: int | None = None

    def __post_init__(self) -> None:
        require_choice("preset", self.preset, tuple(PRESETS))
        if self.warp_count is not None:
            require_count("warp_count", self.warp_count, least=1, most=1000)

    @property
    def settings(self) -> Settings:
        """The preset's, and what differs from it."""
        preset = PRESETS[self.preset]
        return replace(preset, warp_count=self.warp_count or preset.warp_count)


def _solve(
    first: np.ndarray, second: np.ndarray, mask: np.ndarray, options: BlackAnandanOptions
) -> FlowField:
    settings = options.settings
    first = grey = extended(first, mask)
    flow, linked = _start(first, second, settings), np.ones_like(mask)
    if settings.texture:
        span = max(float(picture.max() - picture.min()) for picture in (first, second)) or 1.0
        first, second = texture(first, span), texture(second, span)
    margin = _TEXTURE_MARGIN if settings.texture else _MARGIN
    for stage in settings.stages:
        pyramid = levels(
            first,
            second,
            grey,
            mask,
            spacing=stage.spacing,
            most=stage.level_count,
            margin=margin,
            blur=settings.blur,
        )
        for level in pyramid:
            flow = carried(flow, linked, level.usable.shape)
            energy = Energy(level, stage)
            flow = _refined(energy, level, flow, settings, weighted=stage.convex < 1)
            linked = level.linked > 0
    return FlowField(flow, mask, standard_deviation(energy, flow))


def _start(first: np.ndarray, second: np.ndarray, settings: Settings) -> np.ndarray:
    """Rest, or a coarse search's motion and, where it explains a pixel better, the shift that most share."""
    start = np.zeros((*first.shape, 2), np.float32)
    if not settings.coarse_start:
        return start
    if min(first.shape) >= least_side(_FINEST):
        start = search(to_8bit(first), to_8bit(second), finest=_FINEST)
    shift = common_shift(first, second)
    return start if shift is None else better_of(first, second, np.full_like(start, shift), start)


def _refined(
    energy: Energy, level: Level, flow: np.ndarray, settings: Settings, *, weighted: bool
) -> np.ndarray:
    # A quadratic penalty weighs every motion alike: the same equations again would tell nothing new.
    weighing_count = settings.weighing_count if weighted else 1
    for _ in range(settings.warp_count):
        warped = energy.linearize(flow)
        for _ in range(weighing_count):
            flow = energy.lowered(flow, settings.tolerance)
        if settings.median > 1:
            flow = filtered(
                flow, settings.median, level, warped if weighted and settings.nonlocal_median else None
            )
    return flow


def _resolved(options: BlackAnandanOptions) -> dict[str, object]:
    return {"preset": options.preset} | asdict(options.settings)


ESTIMATOR = Estimator(
    "black-anandan",
    BlackAnandanOptions,
    _solve,
    resolved=_resolved,
    least_side=LEAST_SIDE,
    devices=DEVICES,
    keeps_to_mask=True,
    start=start_taichi,
    forward_backward=MISSES,
    backward=way_back,
)
