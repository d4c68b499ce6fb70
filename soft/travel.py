"""How fast the camera travels over a sequence, and how steadily (section 3.1.2)."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray

# Of a normal distribution, 95 % lie within so many standard deviations of its mean.
_NORMAL_95 = 1.96


@dataclass(frozen=True)
class CameraSpeed:
    """Apparent displacement of resting soil over all pairs, as "7.23 +- 0.34 px a frame" in section 3.1.2.

    Attributes
    ----------
    pair_count : int
        Pairs whose camera motion is known.
    u, v : float
        Mean over the pairs in px, x right and y down; NaN where there are none, and `v` where the vertical
        was not asked for.
    u_range, v_range : float
        1.96 standard deviations over the pairs in px: 95 % of them lie within so much of the mean. It holds
        what the carriage, vibration and the camera's clock do as well as errors of the measurement. NaN for
        fewer than two pairs.
    metres_per_second : float or None
        Of 1 px a pair; None without a calibration.
    """

    pair_count: int
    u: float
    u_range: float
    v: float
    v_range: float
    metres_per_second: float | None

    @classmethod
    def of(
        cls, u: np.ndarray, v: np.ndarray | None, *, metres_per_second: float | None = None
    ) -> "CameraSpeed":
        """Take the camera's motion in every pair, (pair,) px each; `v` None where it was not asked for."""
        known = np.isfinite(u)
        down = np.full(1, np.nan) if v is None else v[known]
        mean_u, range_u = _mean_and_range(u[known])
        mean_v, range_v = _mean_and_range(down)
        return cls(int(known.sum()), mean_u, range_u, mean_v, range_v, metres_per_second)

    @property
    def along(self) -> tuple[float, float] | None:
        """The camera's speed along the bin in m/s, to the right positive, and its 95 % range."""
        scale = self.metres_per_second
        # Resting soil goes to the left where the camera goes to the right.
        return None if scale is None else (-self.u * scale, self.u_range * scale)

    def __str__(self) -> str:
        """In one line: px a pair and, where calibrated, cm/s."""
        if not self.pair_count:
            return "unknown: no pair has soil whose motion was measured"
        pairs = f"95 % of {self.pair_count} pairs" if self.pair_count > 1 else "1 pair"
        line = f"resting soil {_pm(self.u, self.u_range)} px a pair ({pairs})"
        if np.isfinite(self.v):
            line += f", vertical {_pm(self.v, self.v_range)} px"
        if self.along is not None:
            speed, spread = (100 * value for value in self.along)
            line += f": camera {_pm(speed, spread)} cm/s to the right"
        return line


def camera_speed(flow: "xarray.Dataset") -> CameraSpeed:
    """How fast the camera travelled in a SoilFlow.

    Parameters
    ----------
    flow : xarray.Dataset
        A SoilFlow, calibrated or not.
    """
    scale, rate = flow.attrs.get("metres_per_pixel"), flow.attrs.get("frame_rate")
    metres_per_second = None
    if scale is not None and rate is not None and flow.sizes["pair"]:
        frames = int(flow["second_frame"][0]) - int(flow["first_frame"][0])
        metres_per_second = float(scale) * float(rate) / frames
    u, v = (flow[name].values.astype(np.float64) for name in ("camera_u", "camera_v"))
    return CameraSpeed.of(u, v if flow.attrs.get("vertical") else None, metres_per_second=metres_per_second)


def _mean_and_range(values: np.ndarray) -> tuple[float, float]:
    if not values.size:
        return float("nan"), float("nan")
    spread = _NORMAL_95 * float(np.std(values, ddof=1)) if values.size > 1 else float("nan")
    return float(np.mean(values)), spread


def _pm(value: float, spread: float) -> str:
    value = round(value, 3) + 0.0  # nothing has no sign
    return f"{value:.3f} ± {spread:.3f}" if np.isfinite(spread) else f"{value:.3f}"
