"""The points of a design: which values each member of a sweep has."""

import itertools
import math
import warnings
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from synth.dataset.sweep import Span, Sweep, SweepError

if TYPE_CHECKING:
    import numpy as np

MOST_POINTS = 1_000_000
Point = dict[str, Any]
"""Value by dotted key of the scene."""


def points_of(sweep: Sweep) -> list[Point]:
    """All points of a sweep's design, in order; the same for the same sweep.

    Raises
    ------
    SweepError
        A grid of more than a million points.
    """
    if sweep.design.kind == "grid":
        return list(_grid(sweep))
    return [_point(sweep, place) for place in _places(sweep)]


def _grid(sweep: Sweep) -> Iterator[Point]:
    axes = {key: _steps(v) if isinstance(v, Span) else v for key, v in sweep.vary.items()}
    count = math.prod(len(values) for values in axes.values())
    if count > MOST_POINTS:
        raise SweepError(f"vary: a grid of {count} points: at most {MOST_POINTS} are allowed")
    return (dict(zip(axes, values, strict=True)) for values in itertools.product(*axes.values()))


def _steps(span: Span) -> list[float]:
    """Values of a grid's span, both ends among them."""
    assert span.count is not None
    inner = (k / (span.count - 1) for k in range(span.count))
    return list(dict.fromkeys(_between(span, share) for share in inner))


def _places(sweep: Sweep) -> "np.ndarray":
    """Points of the unit cube, (count, keys).

    Scrambled Sobol points keep their balance in numbers that are powers of two; others are allowed, too.
    """
    import numpy as np
    from scipy.stats import qmc

    kinds = {"latin_hypercube": qmc.LatinHypercube, "sobol": qmc.Sobol}
    sampler = kinds[sweep.design.kind](d=len(sweep.vary), rng=np.random.default_rng(sweep.seed))
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="The balance properties of Sobol")
        return sampler.random(sweep.design.count)


def _point(sweep: Sweep, place: "np.ndarray") -> Point:
    chosen = zip(sweep.vary.items(), place.tolist(), strict=True)
    return {key: _value(values, share) for (key, values), share in chosen}


def _value(values: "list[Any] | Span", share: float) -> Any:
    """What stands at a share (0 to 1) of the way through some values."""
    if isinstance(values, list):
        return values[min(int(share * len(values)), len(values) - 1)]
    if not values.integer:
        return _between(values, share)
    # Each whole number has a share of its own, of the same width on a linear scale.
    wide = values.model_copy(update={"low": values.low - 0.5, "high": values.high + 0.5, "integer": False})
    return int(min(max(round(_between(wide, share)), values.low), values.high))


def _between(span: Span, share: float) -> float:
    if span.scale == "log":
        value = span.low * (span.high / span.low) ** share
    else:
        value = span.low + (span.high - span.low) * share
    return round(value) if span.integer else float(value)
