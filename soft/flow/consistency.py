"""Whether motion there and motion back agree: the forward-backward check.

A pixel that moves by `f` lands where the motion from the second to the first picture, `b`, should take it
back. What is hidden in the second picture, or was mistaken for something else, is not taken back.
"""

from dataclasses import dataclass

import numpy as np

from soft.flow.field import FlowError, known
from soft.flow.options import require_number

_SHARE, _SLACK = 0.01, 0.5
"""Of Sundaram, Brox and Keutzer, ECCV 2010, Eq. 5: of the squared lengths, and px^2."""
_AROUND = 5
"""Side of the square that closes and widens the region where pixels land, px."""


@dataclass(frozen=True)
class Check:
    """How far there and back may miss: by `tolerance` px or, if that is None, as was published."""

    tolerance: float | None = None

    @classmethod
    def of(cls, wish: bool | float) -> "Check | None":
        """From what a user gives: true, false, or the px it may miss by.

        Raises
        ------
        FlowError
            Anything else.
        """
        if isinstance(wish, bool):
            return cls() if wish else None
        if not isinstance(wish, int | float):
            raise FlowError(f"forward_backward: {wish!r}: must be true, false, or a number of px above 0")
        require_number("forward_backward", wish, above=0.0)
        return cls(float(wish))

    def passed(self, forward: np.ndarray, back: np.ndarray) -> np.ndarray:
        """Tell where there and back agree; (H, W) bool, False where either is not known.

        Parameters
        ----------
        forward : (H, W, 2) float32
            Displacement from the first to the second picture, px.
        back : (H, W, 2) float32
            The way back from where that ends (`read_back`), px.

        Notes
        -----
        Without a tolerance, |f + b|^2 < 0.01 (|f|^2 + |b|^2) + 0.5 (Sundaram, Brox and Keutzer 2010, Eq. 5).
        """
        missed = _squared(forward + back)
        if self.tolerance is not None:
            return missed < self.tolerance**2
        return missed < _SHARE * (_squared(forward) + _squared(back)) + _SLACK


def read_back(forward: np.ndarray, backward: np.ndarray) -> np.ndarray:
    """Backward displacement where each pixel lands, between pixels linearly; (H, W, 2) float32 px.

    Parameters
    ----------
    forward : (H, W, 2) float32
        On the first picture's grid, px.
    backward : (H, W, 2) float32
        On the second picture's grid, px; NaN where not measured, which is made up for by the pixels around as
        long as they have half of the weight.
    """
    import cv2

    told = known(backward)
    filled = np.nan_to_num(backward.astype(np.float32))
    filled[~told] = 0
    x, y = landing(forward)
    values = cv2.remap(filled, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    weight = cv2.remap(told.astype(np.float32), x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    values /= np.maximum(weight, 0.5)[:, :, None]
    values[(weight < 0.5) | ~known(forward)] = np.nan
    return values


def landing(forward: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where pixels land: x and y, (H, W) float32 px each; outside the picture where motion is not known."""
    height, width = forward.shape[:2]
    x = np.arange(width, dtype=np.float32) + forward[:, :, 0]
    y = np.arange(height, dtype=np.float32)[:, None] + forward[:, :, 1]
    for place in (x, y):
        place[np.isnan(place)] = -1
    return x, y


def landed(forward: np.ndarray) -> np.ndarray:
    """Pixels of the second picture that what was measured in the first lands on or beside; (H, W) bool."""
    import cv2

    height, width = forward.shape[:2]
    x, y = (np.rint(values).astype(np.intp) for values in landing(forward))
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    mask = np.zeros((height, width), np.uint8)
    mask[y[inside], x[inside]] = 1
    return cv2.dilate(mask, np.ones((_AROUND, _AROUND), np.uint8)) > 0


def _squared(vectors: np.ndarray) -> np.ndarray:
    return vectors[:, :, 0] ** 2 + vectors[:, :, 1] ** 2
