"""The estimator `robust-affine`, step by step.

From a coarse field on (dense inverse search, which bridges large motions), every pixel's brightness equation
is made linear around its own present motion, and affine motions are fitted to the equations (the paper's Eq.
3 and 4), weighted by a Lorentzian (Eq. 5) that narrows (graduated non-convexity):

1. in windows of one size (`windows.fit`), on every second pixel's equation;
2. in windows of several sizes, of which each pixel takes the largest it can bear (`windows.choose`), on all
   equations, the pictures warped anew;
3. where these disagree, motion may break off: models are handed on and windows cut (`edges.mend`);
4. where only small windows were borne, once more on the pictures warped anew, for what is left; further where
   that is more than noise (`windows.fit_rest`).

The preset `fast` is the second step alone, with fewer windows, on every second pixel's equation.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, replace

import numpy as np

from soft.devices import DEVICES, start_taichi
from soft.flow.estimator import Estimator
from soft.flow.field import FlowField
from soft.flow.options import require_choice, require_flag, require_number
from soft.flow.robust_affine.brightness import PicturePair
from soft.flow.robust_affine.edges import mend
from soft.flow.robust_affine.rim import (
    BLURRED,
    DOUBTFUL,
    MARGIN,
    carried_outwards,
    carry_outwards,
    join,
    shrunk,
)
from soft.flow.robust_affine.seed import seed
from soft.flow.robust_affine.uncertainty import standard_deviation, widen_at_rim
from soft.flow.robust_affine.windows import Chosen, Products, Window, choose, fit, fit_rest, repeated, spread
from soft.flow.way_back import MISSES, QUICK_MISSES, quick_way_back, way_back
from soft.growth import grown

PRESETS = ("accurate", "fast")
_THIN = 2
"""The first round, and `fast`, take every second pixel's equation each way; windows are chosen there."""
_FIRST = (Window(4.0, 2), Window(6.0, 4), Window(9.0, 4))
"""Of the first round: the smallest whose motions noise leaves steady."""
_STEADY = 0.05
"""Px, as the median of their standard deviations."""
_WIDE, _NARROW = 3.0, 2.0
"""Widths of the Lorentzian, first and then, in standard deviations of the pictures' noise."""
_FEW_WINDOWS = (Window(2.5, 4), Window(6.0, 8), Window(20.0, 16))
_FEW_CALM_WINDOWS = (Window(4.0, 4), Window(7.0, 8), Window(20.0, 16))
"""Where noise matters."""
_WINDOWS = (Window(2.5, 2), Window(4.0, 2), Window(7.0, 4), Window(12.0, 8), Window(20.0, 8))
_CURVE = Window(4.0, 2)
"""In which, where motion is curved, what is left is fitted once more."""
_JUMP = 0.08
"""Where windows' fits are further apart than this, motion may break off nearby, px."""
_AROUND = 6
"""So far around it models are mended, px."""
_CURVED = 3
"""Up to this one there is something left to fit once more."""
_SLOPE_NOISE = 1.2
"""Factor on the variance by noise, for what interpolation adds: measured on `sand_rotation`, seed 101."""


@dataclass(frozen=True)
class RobustAffineOptions:
    """`fast` stops at windows over every second pixel: several times as fast, less sharp at breaks.

    `confidence` is half the width, in standard deviations, of the intervals that decide on a window's size:
    larger ones smooth more. `edges` says whether models are mended where motion breaks off (None: as the
    preset does).
    """

    preset: str = "accurate"
    confidence: float = 1.7
    edges: bool | None = None

    def __post_init__(self) -> None:
        require_choice("preset", self.preset, PRESETS)
        require_number("confidence", self.confidence, above=0.0)
        if self.edges is not None:
            require_flag("edges", self.edges)

    @property
    def resolved(self) -> "RobustAffineOptions":
        """Everything spelt out."""
        return replace(self, edges=self.preset == "accurate" if self.edges is None else self.edges)


def _solve(
    first: np.ndarray, second: np.ndarray, mask: np.ndarray, options: RobustAffineOptions
) -> FlowField:
    options = options.resolved
    coarse, pair = _begun(first, second, mask, options)
    deep, inner = shrunk(mask, BLURRED), shrunk(mask, DOUBTFUL)
    thin = pair.thinned(_THIN)
    trusted = thin.only(inner[::_THIN, ::_THIN])
    accurate = options.preset == "accurate"
    if accurate:
        coarse = _approached(trusted, coarse)
    thin, models = join(thin, trusted, deep[::_THIN, ::_THIN], coarse)
    if accurate:
        trusted = pair.only(repeated(thin.usable > 0, _THIN, pair.shape) | inner)
        pair, models = join(pair, trusted, deep, spread(models, _THIN, pair.shape))
        chosen = _chosen(pair, models, _WINDOWS, options)
    else:
        chosen = _chosen(thin, models, _FEW_CALM_WINDOWS if pair.noisy else _FEW_WINDOWS, options)
    told = _Told.of(mask.shape)
    if options.edges:
        models = _mended(pair, chosen.spread(pair.shape), chosen)
        models = carried_outwards(models, pair.usable > 0, mask)
        told.take(models)
        models = models[:: chosen.step, :: chosen.step]
    else:
        told.take_chosen(chosen)
        carry_outwards(told.displacement, told.gradient, pair.usable > 0, mask)
        models = chosen.models
    sigma = standard_deviation(chosen, models, options.preset, pair.stretch)
    return told.field(mask, widen_at_rim(repeated(sigma, chosen.step, pair.shape), mask))


def _begun(
    first: np.ndarray, second: np.ndarray, mask: np.ndarray, options: RobustAffineOptions
) -> tuple[np.ndarray, PicturePair]:
    """The coarse field, and the pictures made ready meanwhile: the search leaves cores idle at times."""
    with ThreadPoolExecutor(1) as beside:
        ready = beside.submit(PicturePair.of, first, second, shrunk(mask, MARGIN))
        coarse = seed(first, second, quick=options.preset == "fast")
        return coarse, ready.result().calmed(first, second, coarse, _THIN)


@dataclass(frozen=True, eq=False)
class _Told:
    """What a field holds: displacement (H, W, 2) and gradient (H, W, 4), float32."""

    displacement: np.ndarray
    gradient: np.ndarray

    @classmethod
    def of(cls, shape: tuple[int, ...]) -> "_Told":
        """Not filled yet."""
        return cls(np.empty((*shape, 2), np.float32), np.empty((*shape, 4), np.float32))

    def take(self, models: np.ndarray) -> None:
        """From models of every pixel."""
        from soft.flow.robust_affine import window_kernels as kernels

        kernels.tell(models, self.displacement, self.gradient)

    def take_chosen(self, chosen: Chosen) -> None:
        """From those of chosen windows, blended."""
        from soft.flow.robust_affine import window_kernels as kernels

        kernels.tell_spread(chosen.models, chosen.step, self.displacement, self.gradient)

    def field(self, mask: np.ndarray, sigma: np.ndarray) -> FlowField:
        """Valid where the mask is."""
        gradient = self.gradient.reshape(*mask.shape, 2, 2)
        return FlowField(self.displacement, mask, sigma, gradient, copy=False)


def _approached(pair: PicturePair, models: np.ndarray) -> np.ndarray:
    constraints = pair.constrain(models)
    noise = constraints.noise()
    products = Products.of(constraints, noise, _WIDE)
    for window in _FIRST:
        found = fit(products, window, models)
        if np.median(found.variance(noise)) < _STEADY**2:
            break
    return found.models(pair.shape, pair.step)


def _chosen(
    pair: PicturePair, models: np.ndarray, windows: tuple[Window, ...], options: RobustAffineOptions
) -> Chosen:
    constraints = pair.constrain(models)
    noise = constraints.noise()
    products = Products.of(constraints, noise, _NARROW)
    if products.step < _THIN:
        products, models = products.gathered(), models[::_THIN, ::_THIN]
    stride = windows[0].stride // products.step
    inflated = noise * pair.stretch * float(np.sqrt(_SLOPE_NOISE * pair.correlation))
    return choose(products, windows, models, stride=stride, noise=inflated, confidence=options.confidence)


def _mended(pair: PicturePair, models: np.ndarray, chosen: Chosen) -> np.ndarray:
    jumps, curved = (repeated(v, _THIN, pair.shape) for v in (chosen.jump > _JUMP, chosen.level <= _CURVED))
    broken = grown(jumps, _AROUND) & (pair.usable > 0)
    constraints = pair.constrain(models)
    mend(pair, models, constraints, broken)
    noise = constraints.noise()
    products = Products.of(constraints, noise, _NARROW, rest=True).gathered()
    fit_rest(products, _CURVE, noise * float(np.sqrt(pair.correlation))).add_to(
        models, np.ascontiguousarray(curved)
    )
    return models


def _backward(
    first: np.ndarray, second: np.ndarray, forward: FlowField, options: RobustAffineOptions
) -> np.ndarray:
    find = quick_way_back if options.preset == "fast" else way_back
    return find(first, second, forward, options)


def _misses(options: RobustAffineOptions) -> float:
    return QUICK_MISSES if options.preset == "fast" else MISSES


def _resolved(options: RobustAffineOptions) -> dict[str, object]:
    return asdict(options.resolved)


ESTIMATOR = Estimator(
    "robust-affine",
    RobustAffineOptions,
    _solve,
    resolved=_resolved,
    least_side=16,
    devices=DEVICES,
    keeps_to_mask=True,
    start=start_taichi,
    forward_backward=_misses,
    backward=_backward,
)
