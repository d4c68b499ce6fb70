"""What the estimators taken from scikit-image share: it is an optional extra, and counts (row, column)."""

from typing import Any

import numpy as np

from soft.flow.field import FlowError

INSTALL = "pip install 'softbed[skimage]'"
LEVELS = 255.0
"""Grey levels that scikit-image's 1.0 stands for: its options are made for pictures of 0 to 1."""


def registration(method: str) -> Any:
    """Import `skimage.registration`.

    Raises
    ------
    FlowError
        It is not installed; the message says how to.
    """
    try:
        from skimage import registration
    except ImportError as error:
        raise FlowError(f"method {method!r} needs scikit-image ({error}): {INSTALL}") from error
    return registration


def to_unit(picture: np.ndarray) -> np.ndarray:
    """Grey 0-255 to 0-1, (H, W) float32."""
    return picture / np.float32(LEVELS)


def to_displacement(flow: np.ndarray) -> np.ndarray:
    """(2, H, W) along rows and columns to (H, W, 2), (u, v) px: both on the first picture's grid."""
    return np.stack([flow[1], flow[0]], axis=-1)
