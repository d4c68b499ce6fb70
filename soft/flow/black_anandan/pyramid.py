"""Both pictures at coarser and coarser levels, and motion carried from one to the next."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from soft.flow.spline import grey_and_slopes, spline_coefficients

LEAST_SIDE = 16
"""Px of the coarsest level's shorter side, at least."""


@dataclass(frozen=True, eq=False)
class Level:
    """One level.

    Attributes
    ----------
    first : (H, W, 3) float32
        The first picture's grey levels, and their slopes along x and y.
    coefficients : (H, W) float32
        Of the second picture's spline.
    grey : (H, W) float32
        The first picture as it looks.
    linked : (H, W) float32
        1 where motion is asked for, else 0: there it is tied to nothing.
    usable : (H, W) float32
        1 where the pictures may be used, else 0: not close to the mask's edge, nor where a coarse pixel holds
        something from beyond.
    """

    first: np.ndarray
    coefficients: np.ndarray
    grey: np.ndarray
    linked: np.ndarray
    usable: np.ndarray


def levels(
    first: np.ndarray,
    second: np.ndarray,
    grey: np.ndarray,
    mask: np.ndarray,
    *,
    spacing: float,
    most: int,
    margin: int,
    blur: float,
) -> Iterator[Level]:
    """Levels of (H, W) float32 pictures from coarse to fine, each `spacing` times the former's size.

    `grey` is the first picture as it looks, whatever was made of it in `first`. Pixels within `margin` px of
    the mask's edge are not used. From level to level pictures are blurred by `blur` * sqrt(spacing) px.
    """
    height, width = first.shape
    fitting = 1 + int(np.log(max(1.0, min(height, width) / LEAST_SIDE)) / np.log(spacing))
    for coarseness in reversed(range(min(fitting, most))):
        size = (round(height / spacing**coarseness), round(width / spacing**coarseness))
        small, other = (_reduced(picture, size, spacing, coarseness, blur) for picture in (first, second))
        linked, usable = (_covered(part, size) for part in (mask, _shrunk(mask, margin)))
        yield Level(
            grey_and_slopes(small),
            spline_coefficients(other),
            _reduced(grey, size, spacing, coarseness, blur),
            (linked >= 0.5).astype(np.float32),
            (usable > 0.99).astype(np.float32),
        )


def extended(values: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Values, and outside a mask those of the nearest pixel within."""
    if mask.all():
        return values
    from scipy.ndimage import distance_transform_edt

    nearest = distance_transform_edt(~mask, return_distances=False, return_indices=True)
    return np.ascontiguousarray(values[tuple(nearest)])


def carried(flow: np.ndarray, mask: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Motion (H, W, 2) px at another size, without what stands outside of its mask."""
    import cv2

    if flow.shape[:2] == size or not mask.any():
        return flow if flow.shape[:2] == size else np.zeros((*size, 2), np.float32)
    scale = np.array([size[1] / flow.shape[1], size[0] / flow.shape[0]], np.float32)
    return cv2.resize(extended(flow, mask), size[::-1], interpolation=cv2.INTER_LINEAR) * scale


def _reduced(
    picture: np.ndarray, size: tuple[int, int], spacing: float, coarseness: int, blur: float
) -> np.ndarray:
    """A picture at a coarser level: as if blurred and reduced level by level."""
    import cv2

    if coarseness:
        sigma = blur * np.sqrt(spacing * (spacing ** (2 * coarseness) - 1) / (spacing**2 - 1))
        picture = cv2.GaussianBlur(picture, (0, 0), sigma)
    return cv2.resize(picture, size[::-1], interpolation=cv2.INTER_LINEAR)


def _covered(mask: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Share of each coarse pixel that a mask covers."""
    import cv2

    return cv2.resize(mask.astype(np.float32), size[::-1], interpolation=cv2.INTER_AREA)


def _shrunk(mask: np.ndarray, margin: int) -> np.ndarray:
    """A mask less the pixels within `margin` px of something else."""
    import cv2

    kernel = np.ones((2 * margin + 1, 2 * margin + 1), np.uint8)
    return cv2.erode(mask.astype(np.uint8), kernel, borderType=cv2.BORDER_REPLICATE) > 0
