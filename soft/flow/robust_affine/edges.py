"""Where motion breaks off: models handed on from pixel to pixel, and windows cut where pixels move otherwise.

A window that straddles a break fits neither side. There, each pixel tries its neighbours' models, carried
over by their own gradients, and keeps the one under which the pictures agree best around it; then it is
fitted again with those pixels alone that move as its model says.
"""

from dataclasses import dataclass

import numpy as np

from soft.flow.robust_affine.brightness import Constraints, PicturePair

RINGS = ((12, 6), (3,))
"""Radii of the circles from which models are tried, px: those of the first round, then the second."""
_DIRECTIONS = 8
_BOX = 5
"""Side of the box that costs are averaged over, px."""
_SHIFT = 3
"""Side of the area that the box may be shifted in, so that it need not straddle a break, px."""
_COST_WIDTH = 3.0
"""Of the Lorentzian that judges models, in standard deviations of the pictures' noise."""
_FIT_WIDTH = 2.0
"""Of the one that weighs equations."""
_WINDOW = 3.0
"""Scale of the cut window, px."""
_REACH = 7
_APART = 0.7
"""A pixel that moves three times this otherwise than a model says takes no part in its fit, px."""
_MEDIAN = 5
"""Side of the median over motions, px."""


@dataclass(frozen=True, eq=False)
class _Zone:
    """Where to work: `mask` (H, W) bool, and its pixels' rows and columns (P, 2) int32."""

    mask: np.ndarray
    places: np.ndarray


def mend(
    pair: PicturePair, models: np.ndarray, constraints: Constraints, mask: np.ndarray
) -> tuple[np.ndarray, Constraints]:
    """Find better models near breaks of the motion.

    Parameters
    ----------
    pair : PicturePair
    models : (H, W, 6) float32
    constraints : Constraints
        At these models.
    mask : (H, W) bool
        Where to look.

    Returns
    -------
    models : (H, W, 6) float32
        The same, but better where the pictures say so.
    constraints : Constraints
        At them.
    """
    if not mask.any():
        return models, constraints
    zone = _Zone(mask, np.argwhere(mask).astype(np.int32))
    noise = constraints.noise()
    found = models
    for radii in RINGS:
        found = _propagated(pair, found, constraints, zone, radii, noise)
        _smooth(found, zone)
    renewed = pair.constrain_again(constraints, found, zone.places)
    found = _refitted(renewed, found, zone, noise)
    _smooth(found, zone)
    renewed = pair.constrain_again(constraints, found, zone.places)
    width = _FIT_WIDTH * noise
    better = mask & (_boxed(_costs(renewed, width)) < _boxed(_costs(constraints, width)))
    renewed.values[~better] = constraints.values[~better]
    return np.where(better[:, :, None], found, models), renewed


def _propagated(
    pair: PicturePair,
    models: np.ndarray,
    constraints: Constraints,
    zone: _Zone,
    radii: tuple[int, ...],
    noise: float,
) -> np.ndarray:
    from soft.flow.robust_affine import edge_kernels as kernels

    width = _COST_WIDTH * noise
    cost = _costs(constraints, width)  # beside the zone; every candidate's own is written over the rest
    found, candidates = models.copy(), np.empty((len(zone.places), 6), np.float32)
    least = np.full(zone.mask.shape, np.inf, np.float32)
    for right, down in [(0, 0), *(offset for radius in radii for offset in _ring(radius))]:
        kernels.try_neighbours(
            zone.places, right, down, pair.first, pair.coefficients, constraints.gain, pair.usable,
            width, found, candidates, cost,
        )  # fmt: skip
        kernels.take_better(zone.places, candidates, _shifted(cost), least, found)
    return found


def _ring(radius: int) -> list[tuple[int, int]]:
    angles = 2 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    return [(round(radius * np.cos(angle)), round(radius * np.sin(angle))) for angle in angles]


def _costs(constraints: Constraints, width: float) -> np.ndarray:
    """Lorentzian of every pixel's residual; 1.5 where there is none."""
    z = constraints.values[:, :, 4] / np.float32(width)
    return np.where(constraints.values[:, :, 3] > 0, np.log1p(z * z / 2), np.float32(1.5))


def _boxed(cost: np.ndarray) -> np.ndarray:
    import cv2

    return cv2.boxFilter(cost, -1, (_BOX, _BOX))


def _shifted(cost: np.ndarray) -> np.ndarray:
    """The least mean cost of the boxes that hold a pixel near their middle."""
    import cv2

    return cv2.erode(_boxed(cost), np.ones((_SHIFT, _SHIFT), np.uint8))


def _smooth(models: np.ndarray, zone: _Zone) -> None:
    """Put the median of the motions around each pixel of the zone in its place; gradients stay."""
    import cv2

    for component in (0, 3):
        motion = np.ascontiguousarray(models[:, :, component])
        cv2.copyTo(cv2.medianBlur(motion, _MEDIAN), zone.mask.view(np.uint8), motion)
        models[:, :, component] = motion


def _refitted(constraints: Constraints, models: np.ndarray, zone: _Zone, noise: float) -> np.ndarray:
    from soft.flow.robust_affine import edge_kernels as kernels

    fitted = np.empty((len(zone.places), 6), np.float32)
    kernels.refit(zone.places, constraints.values, _REACH, _WINDOW, _APART, noise, _FIT_WIDTH, models, fitted)
    found = models.copy()
    found[zone.mask] = fitted
    return found
