"""Where a method fails most in a set of pictures, and what is known of that place."""

from typing import TYPE_CHECKING, Any

import numpy as np

from validation.scoring.truth_pass import TruePair

if TYPE_CHECKING:
    import xarray as xr

SIDE = 97
"""px, of what is kept around the place."""
_AROUND = 15
"""px; the mean error over a square this wide is what is greatest there."""
_UNMEASURED = 3.0
"""px; what a pixel that is not measured counts for in that mean."""
_CLOSE = 5.0
"""px; a place is at the implement, or at a discontinuity, when it is this near."""
_SHEARED = 0.1
"""1/frame; shear strain from which a place is sheared."""


def worst_place(picture: np.ndarray, true: TruePair, flow: "xr.Dataset") -> "xr.Dataset":
    """Cut out the surroundings of the greatest mean error of one pair.

    Parameters
    ----------
    picture : (H, W) array
        The first one, grey.
    true : TruePair
    flow : xarray.Dataset
        Over `y, x`.

    Returns
    -------
    xarray.Dataset
        Over `worst_y, worst_x`: `worst_picture`, `worst_speed` (true, inertial, px), `worst_error` (px, NaN
        where not measured or no soil). Attributes: `worst_mean` (px), `worst_at` (x, y), `worst_because`.
    """
    import xarray as xr

    truth, strata = true.data, true.strata
    soil = strata.masks["all"]
    error = np.hypot(flow["u"].values - truth["u"].values, flow["v"].values - truth["v"].values)
    if "valid" in flow:
        error = np.where(flow["valid"].values.astype(bool), error, np.nan)
    mean = _mean_around(np.where(np.isfinite(error), np.minimum(error, 10.0), _UNMEASURED), soil)
    y, x = (int(k) for k in np.unravel_index(np.argmax(mean), mean.shape))
    shown = np.where(soil, error, np.nan)
    cut = {
        "worst_picture": _cut(picture.astype(np.float32), y, x, fill=0.0),
        "worst_speed": _cut(np.where(soil, strata.speed, np.nan).astype(np.float32), y, x, fill=np.nan),
        "worst_error": _cut(shown.astype(np.float32), y, x, fill=np.nan),
    }
    told = {
        "worst_mean": float(mean[y, x]),
        "worst_at": [x, y],
        "worst_because": _because(truth.isel(y=y, x=x), error, soil, y, x),
    }
    return xr.Dataset({name: (("worst_y", "worst_x"), a) for name, a in cut.items()}, attrs=told)


def _mean_around(error: np.ndarray, soil: np.ndarray) -> np.ndarray:
    """Mean over the soil of a square; -1 where less than a third of it is soil."""
    import cv2

    size = (_AROUND, _AROUND)
    share = cv2.blur(soil.astype(np.float32), size, borderType=cv2.BORDER_CONSTANT)
    total = cv2.blur(np.where(soil, error, 0).astype(np.float32), size, borderType=cv2.BORDER_CONSTANT)
    return np.where(soil & (share > 1 / 3), total / np.maximum(share, 1e-6), -1.0)


def _cut(field: np.ndarray, y: int, x: int, *, fill: float) -> np.ndarray:
    half = SIDE // 2
    padded = np.pad(field, half, constant_values=fill)
    return padded[y : y + SIDE, x : x + SIDE]


def _because(here: Any, error: np.ndarray, soil: np.ndarray, y: int, x: int) -> str:
    """What is known of the place, in words."""
    half = _AROUND // 2
    part = np.s_[max(y - half, 0) : y + half + 1, max(x - half, 0) : x + half + 1]
    missing = float(np.mean(np.isnan(error[part])[soil[part]])) if soil[part].any() else 0.0
    told = [f"{missing:.0%} not measured"] if missing > 0.2 else []
    if here["distance_to_implement"] <= _CLOSE:
        told.append("at the implement")
    if here["distance_to_discontinuity"] <= _CLOSE:
        told.append(f"at a jump of {float(here['discontinuity_jump']):.1f} px")
    if here["strain_rate"] >= _SHEARED:
        told.append(f"sheared by {float(here['strain_rate']):.2f} a frame")
    if abs(here["rotation"]) >= _SHEARED:
        told.append(f"turning by {abs(float(here['rotation'])):.2f} rad a frame")
    return ", ".join(told) or "in soil that moves smoothly"
