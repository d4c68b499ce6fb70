"""The camera's motion as measured beside the true one (section 3.1.2).

What is off has two parts: errors of the measured flow, and soil in view that does not rest. They are told
apart by finding the camera's motion in the true displacement, too, in the same way.
"""

from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from validation.statistics import NORMAL_95

if TYPE_CHECKING:
    import xarray as xr

    from validation.scoring.truth_pass import TruePair


@dataclass(frozen=True)
class CameraScore:
    """Measured less true apparent displacement of resting soil, over all pairs.

    Attributes
    ----------
    pair_count : int
        Pairs whose camera motion was measured.
    bias_u : float or None
        Mean error in px; None where no pair was measured.
    range_u : float or None
        1.96 standard deviations of the errors in px; None for fewer than two pairs.
    largest_u : float or None
        Largest magnitude of an error in px.
    measured_range_u : float or None
        1.96 standard deviations of the measured motion in px; 0.34 px over 50 pairs are published (section
        3.1.2), which hold what the rig did, too.
    true_range_u : float or None
        The same of the true motion: by vibration, jitter and drive.
    covered : float or None
        Share of the pairs with an interval whose true motion lies in it; 0.95 is what is promised.
    flow_range_u : float or None
        1.96 standard deviations of measured less what the true displacement of soil gives in the same way, in
        px: what the measurement of flow errs by.
    soil_range_u : float or None
        The same of what the true displacement gives less the true motion: what soil that does not rest makes.
    """

    pair_count: int
    bias_u: float | None
    range_u: float | None
    largest_u: float | None
    measured_range_u: float | None
    true_range_u: float | None
    covered: float | None
    flow_range_u: float | None
    soil_range_u: float | None

    def to_dict(self) -> dict[str, Any]:
        """As it stands in scores.json."""
        return asdict(self)

    def __str__(self) -> str:
        """In one line."""
        if self.bias_u is None:
            return "not measured"
        if self.range_u is None:
            return f"off by {self.bias_u:+.3f} px (1 pair)"
        covered = "" if self.covered is None else f", true motion in {self.covered:.0%} of the intervals"
        return (
            f"off by {self.bias_u:+.3f} ± {self.range_u:.3f} px (95 % of {self.pair_count} pairs: flow "
            f"± {self.flow_range_u:.3f}, soil that does not rest ± {self.soil_range_u:.3f}), "
            f"at most {self.largest_u:.3f} px; measured range ± {self.measured_range_u:.3f} px, "
            f"true ± {self.true_range_u:.3f} px{covered}"
        )


@dataclass
class CameraTally:
    """The camera's motion by one method, pair by pair.

    Attributes
    ----------
    camera : str
        How it was found, as `soft.to_inertial` has it.
    """

    camera: str
    _rows: list[tuple[float, ...]] = field(default_factory=list)

    @classmethod
    def of(cls, flow: "xr.Dataset") -> Self:
        """For a SoilFlow."""
        return cls(camera_of(flow))

    def add(self, pair: "TruePair", flow: "xr.Dataset") -> None:
        """Add one pair, unless the truth does not tell the camera's motion, or the method none."""
        if "camera_u" not in pair.data or "camera_u" not in flow:
            return
        low, high = (
            float(flow[name]) if name in flow else np.nan for name in ("camera_u_low", "camera_u_high")
        )
        by_soil = pair.camera_by_soil(self.camera)
        self._rows.append((pair.camera[0], float(flow["camera_u"]), low, high, by_soil))

    def result(self) -> CameraScore | None:
        """Over all pairs added; None if there were none."""
        if not self._rows:
            return None
        true, measured, low, high, by_soil = np.array(self._rows).T
        known = np.isfinite(measured) & np.isfinite(true)
        error = (measured - true)[known]
        return CameraScore(
            pair_count=error.size,
            bias_u=float(error.mean()) if error.size else None,
            range_u=_range(error),
            largest_u=float(np.abs(error).max()) if error.size else None,
            measured_range_u=_range(measured[known]),
            true_range_u=_range(true[known]),
            covered=_covered(low, high, true),
            flow_range_u=_range((measured - by_soil)[known]),
            soil_range_u=_range((by_soil - true)[known]),
        )


def camera_of(flow: "xr.Dataset") -> str:
    """How a SoilFlow's camera motion was found: the first word of what the analysis says of it."""
    return str(flow.attrs.get("camera", "median")).split()[0]


def _range(values: np.ndarray) -> float | None:
    return NORMAL_95 * float(values.std(ddof=1)) if values.size > 1 else None


def _covered(low: np.ndarray, high: np.ndarray, true: np.ndarray) -> float | None:
    told = np.isfinite(low) & np.isfinite(high) & np.isfinite(true)
    return float(((low <= true) & (true <= high))[told].mean()) if told.any() else None
