"""The rim of a mask: where soil ends, and where light of something else comes in.

At a free surface the soil's edge moves as the soil does and tells a lot. At an implement the edge is the
implement's, and so steep that a few of its pixels outweigh all soil around. Grey levels do not tell the one
from the other, but motion does: pixels at the rim are used only if the pictures agree there with the motion
carried over from within. The outermost ones are not used even then, for an implement's light is blurred over
them; but they are looked at, since they show best that what lies beyond moves otherwise.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from soft.flow.robust_affine.brightness import PicturePair
from soft.growth import grown

MARGIN = 1
"""Px at a mask's rim that are not even looked at, though measured."""
BLURRED = 3
"""Px at a mask's rim that are never used, where there are others."""
DOUBTFUL = 5
"""So far from the rim pixels have to prove themselves, px."""
_SLACK = 0.2
"""Motion carried over may be off by so much without putting a pixel off, px."""
_AGREEING = 2.5
"""Mean square of the residuals, in units of what noise and slack make of it, up to which pixels are used."""
_OUTLIER = 20.0
"""What a single one counts at most."""
_BOX = 5
"""Side of the box over which it is averaged, px."""


def shrunk(mask: np.ndarray, by: int) -> np.ndarray:
    """A mask (H, W) bool without the pixels at most `by` px from what lies outside of it."""
    return mask if mask.all() else ~grown(~mask, by)


def join(
    pair: PicturePair, trusted: PicturePair, deep: np.ndarray, models: np.ndarray
) -> tuple[PicturePair, np.ndarray]:
    """Use those pixels, besides the trusted ones, that move as these do and are not at the very rim.

    Parameters
    ----------
    pair : PicturePair
        With every pixel that is looked at.
    trusted : PicturePair
        The same with fewer: those that are used anyway.
    deep : (H, W) bool
        Pixels that may be used.
    models : (H, W, 6) float32
        Motion found with these.

    Returns
    -------
    pair : PicturePair
        With the trusted and the agreeing pixels.
    models : (H, W, 6) float32
        Carried over to all that are looked at.
    """
    import cv2

    may, sure = pair.usable > 0, trusted.usable > 0
    rim = may & ~sure
    if not (rim.any() and sure.any()):
        return trusted if sure.any() else pair, models
    models = carried_outwards(models, sure, may)
    constraints = trusted.constrain(models)
    jx, jy, residual = (constraints.values[:, :, k] for k in (0, 1, 4))
    expected = constraints.noise() ** 2 + _SLACK**2 * (jx * jx + jy * jy)
    off = np.where(rim, np.minimum(residual * residual / expected, _OUTLIER), 0).astype(np.float32)
    side = max(3, _BOX // pair.step)
    share = cv2.boxFilter(rim.astype(np.float32), -1, (side, side))
    agreeing = rim & (cv2.boxFilter(off, -1, (side, side)) < _AGREEING * share)
    return replace(pair, usable=((sure | agreeing) & deep).astype(np.float32)), models


def carried_outwards(models: np.ndarray, usable: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Models of what is to be measured but not to be used, from the nearest pixel that was used."""
    rim = mask & ~usable
    if not (rim.any() and usable.any()):
        return models
    carried = models.copy()
    carried[rim] = _handed(usable, rim, lambda rows, columns: models[rows, columns])
    return carried


def carry_outwards(
    displacement: np.ndarray, gradient: np.ndarray, usable: np.ndarray, mask: np.ndarray
) -> None:
    """Do the same to displacements (H, W, 2) and gradients (H, W, 4), in place."""
    rim = mask & ~usable
    if not (rim.any() and usable.any()):
        return

    def models(rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        own, slopes = displacement[rows, columns], gradient[rows, columns]
        return np.concatenate([own[:, :1], slopes[:, :2], own[:, 1:], slopes[:, 2:]], axis=1)

    handed = _handed(usable, rim, models)
    displacement[rim], gradient[rim] = handed[:, ::3], handed[:, [1, 2, 4, 5]]


def _handed(
    usable: np.ndarray, rim: np.ndarray, models: Callable[[np.ndarray, np.ndarray], np.ndarray]
) -> np.ndarray:
    """Models (P, 6) for the rim's pixels: those at the nearest usable ones, carried over."""
    import cv2

    _, labels = cv2.distanceTransformWithLabels(
        (~usable).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    source = np.zeros((labels.max() + 1, 2), np.intp)
    source[labels[usable]] = np.argwhere(usable)
    places, nearest = np.argwhere(rim), source[labels[rim]]
    down, right = (places - nearest).T.astype(np.float32)
    handed = models(nearest[:, 0], nearest[:, 1])
    for k in (0, 3):
        handed[:, k] += handed[:, k + 1] * right + handed[:, k + 2] * down
    return handed
