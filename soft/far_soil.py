"""The camera's motion by what soil tends to far from what moves it.

Around an implement no soil rests quite, but what it moves by falls off with distance `r` from the implement:
in a plane as 1/r where it passes a force on, as 1/r^2 where it makes room for a body (what a line force that
changes and a body that travels do to a continuum). Of a motion d - c that falls off as r^-p, Euler's theorem
says

    (x - x0) . grad d = -p (d - c),    so that    c = d + (x - x0) . grad d / p

at every pixel by itself (as sources of potential fields are found: Reid et al., Geophysics 55, 1990). Where
soil hardly deforms, it is little that is added; so there c is looked for.
"""

import numpy as np

from soft.gradient import displacement_gradient
from soft.location import UNKNOWN, Location, weighted_quantiles

DECAY = 1.75
"""Exponent p: between that of a force and that of a body."""

SCALE_SHARE = 1 / 30
"""Of the picture's shorter side: standard deviation of the window that the gradient is fitted in."""

LEAST_SCALE = 10.0
"""Px: wide enough for errors of flow."""

_CELLS_A_SCALE = 5
"""Motion is averaged over cells of that part of the scale first, which saves time and nothing else."""

_CELLS_A_SPACING = 2.0
"""Cells that a window's standard deviation spans at least, where a grid's nodes make them large."""

_STILL_SHARE = 0.05
"""Of the soil: the gradient below which this much of it lies is not told apart from none."""

_FAST_SHARE = 0.1
"""Of the soil: so much of it, the fastest, is where motion comes from."""

_DECAYS = (1.0, 2.5)
"""Least and greatest exponent that the interval reckons with."""

_QUARTILES = [0.25, 0.75]
"""The interval holds the middle half of what soil says of the camera: what is wrong in one place is wrong all
around, so the middle of many is hardly better known than one. So wide, it holds the true motion in 95 % of
the pairs of simulated scenes."""

_LEAST_GRADIENT = 1e-6
"""px/px."""

_LEAST_CELL_COUNT = 200
"""Fewer cells, eight windows' worth, say too little about how they differ."""

_ITERATIONS = 10
_CLOSE = 1e-4
"""Px: a camera that is moved by less moves no more."""


def far_locations(displacement: np.ndarray, soil: np.ndarray) -> tuple[Location, Location]:
    """Find what motion tends to far from the soil that moves fastest, in u and in v.

    At each place, Euler's theorem gives the camera's motion; over all, the median counts in which each place
    has the weight `1 / (1 + (g / g0)^2)`: `g` is the gradient of motion there, `g0` the stillest soil's.

    Parameters
    ----------
    displacement : (H, W, 2) array
        In px; NaN where it was not measured. Of a grid, the nodes alone are.
    soil : (H, W) bool
        Where soil is.

    Returns
    -------
    Location, Location
        In px; the interval holds the middle half of what the places say, however fast motion falls off.
        Unknown where nothing was measured; without an interval where it was measured in too few places.
    """
    motion, gradient, places = _cells(displacement, soil)
    known = np.isfinite(gradient).all(axis=(1, 2))
    if not known.any():
        return _plain_median(motion)
    motion, gradient, places = motion[known], gradient[known], places[known]
    weight = _stillness(gradient)
    camera = _middle(motion, weight)
    for _ in range(_ITERATIONS):
        # The rate at which motion falls off, per relative distance from where it comes from, px.
        fall = np.einsum("nij,nj->ni", gradient, places - _source(motion - camera, places))
        former, camera = camera, _middle(motion + fall / DECAY, weight)
        if np.abs(camera - former).max() < _CLOSE:
            break
    u, v = (_located(camera[i], motion[:, i], fall[:, i], weight) for i in (0, 1))
    return u, v


def _cells(displacement: np.ndarray, soil: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean motion of cells (N, 2), its gradient (N, 2, 2) in px/px, and where they are (N, 2): x, y in px."""
    known = soil & np.isfinite(displacement).all(axis=2)
    scale = max(LEAST_SCALE, SCALE_SHARE * min(soil.shape))
    # How far a grid's nodes are apart; 1 px where every pixel was measured.
    spacing = np.sqrt(soil.sum() / max(1, known.sum()))
    side = max(1, round(max(scale / _CELLS_A_SCALE, spacing)))
    counts = _summed(known.astype(np.float64), side)
    sums = np.stack(
        [_summed(np.where(known, part, 0.0), side) for part in np.moveaxis(displacement, 2, 0)], -1
    )
    with np.errstate(invalid="ignore"):
        motion = sums / counts[:, :, None]
    filled = counts > 0
    gradient = displacement_gradient(motion, filled, scale=max(scale / side, _CELLS_A_SPACING)) / side
    places = np.argwhere(filled)[:, ::-1] * side + (side - 1) / 2
    return motion[filled], gradient[filled].astype(np.float64), places


def _summed(field: np.ndarray, side: int) -> np.ndarray:
    """Sums over cells of `side` px a side; what is left over at the right and lower border is left out."""
    rows, columns = (length // side for length in field.shape)
    cells = field[: rows * side, : columns * side].reshape(rows, side, columns, side)
    return np.asarray(cells.sum(axis=(1, 3)))


def _stillness(gradient: np.ndarray) -> np.ndarray:
    """How much each place counts, (N,) from 0 to 1."""
    norm = np.sqrt(np.square(gradient).sum(axis=(1, 2)))
    return np.asarray(
        1 / (1 + np.square(norm / max(float(np.quantile(norm, _STILL_SHARE)), _LEAST_GRADIENT)))
    )


def _source(motion: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Where soil moves fastest: mean place of the fastest tenth, each by its speed; x, y in px."""
    speed = np.hypot(*motion.T)
    fast = speed >= np.quantile(speed, 1 - _FAST_SHARE)
    total = speed[fast].sum()
    return np.asarray(speed[fast] @ places[fast] / total if total > 0 else places.mean(axis=0))


def _middle(values: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Weighted median of each component of (N, 2) values."""
    return np.array([weighted_quantiles(part, weight, [0.5])[0] for part in values.T])


def _located(value: float, motion: np.ndarray, fall: np.ndarray, weight: np.ndarray) -> Location:
    """One component, with what its places say for the least and the greatest decay."""
    if motion.size < _LEAST_CELL_COUNT:
        return Location(float(value), np.nan, np.nan)
    bounds = [weighted_quantiles(motion + fall / decay, weight, _QUARTILES) for decay in _DECAYS]
    (low, _), (_, high) = np.min(bounds, axis=0), np.max(bounds, axis=0)
    return Location(float(value), float(low), float(high))


def _plain_median(motion: np.ndarray) -> tuple[Location, Location]:
    """Where no gradient can be told."""
    if not len(motion):
        return UNKNOWN, UNKNOWN
    u, v = np.median(motion, axis=0)
    return Location(float(u), np.nan, np.nan), Location(float(v), np.nan, np.nan)
