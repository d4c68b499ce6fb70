"""Median filters over motion between warps (Sun, Roth and Black, CVPR 2010).

Away from motion boundaries the median of a small window; near them a weighted one of a large window, whose
pixels count by how near they are, how alike in grey level, and whether they stay in sight ("Classic+NL").
"""

import numpy as np

from soft.flow.black_anandan.pyramid import Level

_REACH = 7
"""Of the weighted window: 15 x 15 px."""
_DISTANCE = 7.0
"""Standard deviation of the weights over distance, px,"""
_CONTRAST = 7.0
"""and over grey levels."""
_BATCH = 4096
"""Places that are filtered at a time: what they look at fits a processor's cache."""
_BOUNDARY = 0.1
"""Slope of motion, px/px, beyond which a pixel lies at a motion boundary."""
_AROUND = 2
"""Px around a boundary that count as near it."""
_CONVERGENCE, _CHANGE = 0.3, 20.0
"""Widths of what tells pixels that go out of sight: convergence of the motion, change of grey level."""


def filtered(flow: np.ndarray, side: int, level: Level, warped: np.ndarray | None) -> np.ndarray:
    """Motion (H, W, 2) px after a median filter of `side` px.

    `warped` (H, W, 4) is the second picture where each pixel has gone, or None: then the weighted filter is
    only used where the mask cuts the small window, so that nothing comes from beyond.
    """
    import cv2

    result = np.dstack([cv2.medianBlur(np.ascontiguousarray(flow[:, :, k]), side) for k in (0, 1)])
    outside = (level.linked == 0).astype(np.uint8)
    special, worth = cv2.dilate(outside, np.ones((side, side), np.uint8)) > 0, level.linked
    if warped is not None:
        special = special | _near_boundaries(flow)
        worth = worth * _in_sight(flow, level.first[:, :, 0], warped)
    places = np.ascontiguousarray(np.argwhere(special & (level.linked > 0)), np.int32)
    if len(places):
        result[places[:, 0], places[:, 1]] = _weighted(flow, places, level.grey, worth)
    return result


def _weighted(flow: np.ndarray, places: np.ndarray, grey: np.ndarray, worth: np.ndarray) -> np.ndarray:
    """Weighted medians (P, 2) around places, rows and columns (P, 2) int32."""
    from soft.flow.black_anandan.median_kernels import BINS, weighted_median

    away = np.arange(-_REACH, _REACH + 1, dtype=np.float32) ** 2
    near = np.exp(-(away[:, None] + away) / (2 * _DISTANCE**2))
    votes, bins = np.empty((_BATCH, near.size, 3), np.float32), np.empty((_BATCH, BINS), np.float32)
    median = np.empty((len(places), 2), np.float32)
    for start in range(0, len(places), _BATCH):
        some = slice(start, start + _BATCH)
        weighted_median(places[some], grey, worth, flow, near, _CONTRAST, votes, bins, median[some])
    return median


def _near_boundaries(flow: np.ndarray) -> np.ndarray:
    import cv2

    slopes = np.zeros(flow.shape[:2], np.float32)
    for k in (0, 1):
        part = np.ascontiguousarray(flow[:, :, k])
        for dx, dy in ((1, 0), (0, 1)):
            slopes = np.maximum(slopes, np.abs(cv2.Sobel(part, cv2.CV_32F, dx, dy, scale=1 / 8)))
    side = 2 * _AROUND + 1
    return cv2.dilate((slopes > _BOUNDARY).astype(np.uint8), np.ones((side, side), np.uint8)) > 0


def _in_sight(flow: np.ndarray, grey: np.ndarray, warped: np.ndarray) -> np.ndarray:
    """How likely a pixel stays in sight (Sand and Teller, IJCV 80, 2008)."""
    import cv2

    u, v = (np.ascontiguousarray(flow[:, :, k]) for k in (0, 1))
    spread = cv2.Sobel(u, cv2.CV_32F, 1, 0, scale=1 / 8) + cv2.Sobel(v, cv2.CV_32F, 0, 1, scale=1 / 8)
    convergence, change = np.minimum(spread, 0) / _CONVERGENCE, (warped[:, :, 0] - grey) / _CHANGE
    return np.exp(-(convergence**2 + change**2) / 2) * (warped[:, :, 3] > 0)
