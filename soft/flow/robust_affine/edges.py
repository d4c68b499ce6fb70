"""Where motion breaks off: models handed on from pixel to pixel, and windows cut where pixels move otherwise.

A window that straddles a break fits neither side. There, each pixel tries its neighbours' models, carried
over by their own gradients, and keeps the one under which the pictures agree best around it; then it is
fitted again with those pixels alone that move as its model says.
"""

from dataclasses import dataclass

import numpy as np

from soft.flow.robust_affine.brightness import Constraints, PicturePair
from soft.growth import grown

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
    """Where to work.

    Attributes
    ----------
    mask : (H, W) bool
    places : (P, 2) int32
        Rows and columns of its pixels.
    around : (Q, 2) int32
        The same, and those that their costs are averaged over.
    box : tuple of slice
        Rows and columns that hold all of these.
    """

    mask: np.ndarray
    places: np.ndarray
    around: np.ndarray
    box: tuple[slice, slice]

    @classmethod
    def of(cls, mask: np.ndarray) -> "_Zone":
        wider = grown(mask, _BOX // 2 + _SHIFT // 2)
        places, around = (np.argwhere(where).astype(np.int32) for where in (mask, wider))
        least, most = around.min(axis=0), around.max(axis=0) + 1
        return cls(mask, places, around, (slice(least[0], most[0]), slice(least[1], most[1])))

    @property
    def index(self) -> tuple[np.ndarray, np.ndarray]:
        """Of its pixels in an array (H, W, ..)."""
        return self.places[:, 0], self.places[:, 1]


def mend(pair: PicturePair, models: np.ndarray, constraints: Constraints, mask: np.ndarray) -> None:
    """Find better models near breaks of the motion, and put them in place.

    Parameters
    ----------
    pair : PicturePair
    models : (H, W, 6) float32
        Better afterwards where the pictures say so.
    constraints : Constraints
        At these models, afterwards too.
    mask : (H, W) bool
        Where to look.
    """
    if not mask.any():
        return
    zone = _Zone.of(mask)
    noise = constraints.noise()
    models_before, values_before = models[zone.index], constraints.values[zone.index]
    cost_before = _boxed(_costs(constraints, zone, _FIT_WIDTH * noise), zone)[zone.index]
    cost = _costs(constraints, zone, _COST_WIDTH * noise)
    for radii in RINGS:
        _propagate(pair, models, constraints, zone, cost, radii, _COST_WIDTH * noise)
        _smooth(models, zone)
    pair.constrain_again(constraints, models, zone.places)
    _refit(constraints, models, zone, noise)
    _smooth(models, zone)
    pair.constrain_again(constraints, models, zone.places)
    worse = ~(_boxed(_costs(constraints, zone, _FIT_WIDTH * noise), zone)[zone.index] < cost_before)
    back = tuple(axis[worse] for axis in zone.index)
    models[back], constraints.values[back] = models_before[worse], values_before[worse]


def _propagate(
    pair: PicturePair,
    models: np.ndarray,
    constraints: Constraints,
    zone: _Zone,
    cost: np.ndarray,
    radii: tuple[int, ...],
    width: float,
) -> None:
    """Let every place take the best model around; `cost` beside the zone counts, in it every candidate's."""
    from soft.flow.robust_affine import edge_kernels as kernels

    candidates = np.empty((len(zone.places), 6), np.float32)
    least = np.full(zone.mask.shape, np.inf, np.float32)
    for right, down in [(0, 0), *(offset for radius in radii for offset in _ring(radius))]:
        kernels.try_neighbours(
            zone.places, right, down, pair.first, pair.coefficients, constraints.gain, pair.usable,
            width, models, candidates, cost,
        )  # fmt: skip
        kernels.take_better(zone.places, candidates, _shifted(cost, zone), least, models)


def _ring(radius: int) -> list[tuple[int, int]]:
    angles = 2 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    return [(round(radius * np.cos(angle)), round(radius * np.sin(angle))) for angle in angles]


def _costs(constraints: Constraints, zone: _Zone, width: float) -> np.ndarray:
    """Lorentzian of the residuals in and around the zone; 1.5 where there is none, 0 elsewhere."""
    from soft.flow.robust_affine import edge_kernels as kernels

    cost = np.zeros(zone.mask.shape, np.float32)
    kernels.tell_costs(zone.around, constraints.values, width, cost)
    return cost


def _boxed(cost: np.ndarray, zone: _Zone) -> np.ndarray:
    import cv2

    boxed = np.empty_like(cost)
    boxed[zone.box] = cv2.boxFilter(cost[zone.box], -1, (_BOX, _BOX))
    return boxed


def _shifted(cost: np.ndarray, zone: _Zone) -> np.ndarray:
    """The least mean cost of the boxes that hold a pixel near their middle."""
    import cv2

    shifted = np.empty_like(cost)
    boxed = cv2.boxFilter(cost[zone.box], -1, (_BOX, _BOX))
    shifted[zone.box] = cv2.erode(boxed, np.ones((_SHIFT, _SHIFT), np.uint8))
    return shifted


def _smooth(models: np.ndarray, zone: _Zone) -> None:
    """Put the median of the motions around each pixel of the zone in its place; gradients stay."""
    import cv2

    there = models[zone.box]
    within = zone.mask[zone.box]
    for component in (0, 3):
        smooth = cv2.medianBlur(np.ascontiguousarray(there[:, :, component]), _MEDIAN)
        there[within, component] = smooth[within]


def _refit(constraints: Constraints, models: np.ndarray, zone: _Zone, noise: float) -> None:
    from soft.flow.robust_affine import edge_kernels as kernels

    fitted, width = np.empty((len(zone.places), 6), np.float32), _FIT_WIDTH * constraints.stretch
    kernels.refit(zone.places, constraints.values, _REACH, _WINDOW, _APART, noise, width, models, fitted)
    models[zone.index] = fitted
