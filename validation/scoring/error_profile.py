"""Where a method errs: its errors sorted by what is known of each pixel, in a form that can be added up.

For every explanation (distance to the implement, shear rate and others) and every one of its bins, errors are
counted in a histogram of end-point error, and summed along and across the true motion: bias and random error
apart. Profiles of picture pairs, scenes and realisations are added; nothing is averaged before.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from validation.scoring.metrics import end_point_error
from validation.scoring.strata import COMPLEX_WITHIN, Strata, distance_to
from validation.scoring.truth_pass import TruePair

if TYPE_CHECKING:
    import xarray as xr

ERROR_EDGES = np.concatenate([[0.0], np.geomspace(0.004, 32.0, 105), [np.inf]])
"""px, edges of the histogram's bins: each nine per cent wide, so that a percentile is told to about two."""
_DISTANCES = (0.0, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 20.0, 40.0, 80.0, np.inf)
_NEAR = 12.0
"""px; a jump counts for the pixels this near to it."""
_DIRECTED = 0.1
"""px; a slower motion has no direction that errors could be along."""


@dataclass(frozen=True)
class Explanation:
    """Something that may explain an error.

    Attributes
    ----------
    unit, meaning : str
    edges : tuple of float
        Of its bins, the last one infinite; a value at an edge belongs to the bin above.
    of : callable
        Its value at every pixel of a pair's truth, (H, W), NaN where it has none; the second argument is the
        pair's strata.
    classes : tuple of str
        Names of its bins, where these are classes and not a quantity's ranges.
    """

    unit: str
    meaning: str
    edges: tuple[float, ...]
    of: Callable[["xr.Dataset", Strata], np.ndarray]
    classes: tuple[str, ...] = ()


def _variable(name: str) -> Callable[["xr.Dataset", Strata], np.ndarray]:
    return lambda truth, _: np.abs(truth[name].values)


def _jump(truth: "xr.Dataset", _: Strata) -> np.ndarray:
    near = truth["distance_to_discontinuity"].values <= _NEAR
    return np.where(near, truth["discontinuity_jump"].values, np.nan)


def _speed(_: "xr.Dataset", strata: Strata) -> np.ndarray:
    return strata.speed


def _distance_to_lost(truth: "xr.Dataset", _: Strata) -> np.ndarray:
    """Distance to soil that the second picture shows no more: covered, gone or out of the picture."""
    return distance_to(truth["soil"].values & ~truth["valid"].values)


CAUSES = (
    "at soil that is lost",
    "at the implement",
    "at a discontinuity",
    "sheared",
    "turning",
    "beside these",
    "moving, not complex",
    "quiet",
)
"""Every pixel has one, the first that applies; all but the last two are of the stratum `complex`."""
_STEEP = 0.1
"""1/frame; shear strain, or rad/frame; rotation, from which soil is sheared or turning."""


def _cause(truth: "xr.Dataset", strata: Strata) -> np.ndarray:
    """Index into CAUSES."""
    masks = strata.masks
    complicated = masks["complex"]
    within = (
        _distance_to_lost(truth, strata) <= COMPLEX_WITHIN,
        truth["distance_to_implement"].values <= COMPLEX_WITHIN,
        truth["distance_to_discontinuity"].values <= COMPLEX_WITHIN,
        truth["strain_rate"].values >= _STEEP,
        np.abs(truth["rotation"].values) >= _STEEP,
        np.ones(complicated.shape, bool),
    )
    conditions = [*(complicated & one for one in within), masks["moving"], masks["quiet"]]
    return np.select(conditions, list(range(len(CAUSES))), default=np.nan)


EXPLANATIONS = {
    "distance_to_implement": Explanation(
        "px", "distance to the implement", _DISTANCES, _variable("distance_to_implement")
    ),
    "distance_to_discontinuity": Explanation(
        "px", "distance to the nearest discontinuity", _DISTANCES, _variable("distance_to_discontinuity")
    ),
    "discontinuity_jump": Explanation(
        "px",
        f"jump of a discontinuity within {_NEAR:g} px",
        (0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0, np.inf),
        _jump,
    ),
    "strain_rate": Explanation(
        "1/frame",
        "equivalent shear strain a frame",
        (0.0, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, np.inf),
        _variable("strain_rate"),
    ),
    "rotation": Explanation(
        "rad/frame",
        "rotation a frame",
        (0.0, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, np.inf),
        _variable("rotation"),
    ),
    "speed": Explanation(
        "px/frame", "inertial motion", (0.0, 0.3, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 20.0, np.inf), _speed
    ),
    "distance_to_lost": Explanation(
        "px", "distance to soil that the second picture has lost", _DISTANCES, _distance_to_lost
    ),
    "cause": Explanation("", "cause", (*(float(k) for k in range(len(CAUSES))), np.inf), _cause, CAUSES),
}
RANGES = {name: one for name, one in EXPLANATIONS.items() if not one.classes}
"""Those that are quantities."""


def error_profile(true: TruePair, flow: "xr.Dataset") -> "xr.Dataset":
    """Sort the errors of one picture pair by everything that may explain them.

    Parameters
    ----------
    true : TruePair
    flow : xarray.Dataset
        Over `y, x`, dense.

    Returns
    -------
    xarray.Dataset
        For each explanation NAME, over its bins `bin_NAME`: `count_NAME` (over `error_bin`, too), pixels by
        end-point error; `unmeasured_NAME`, pixels; `sums_NAME` (over `moment`), sums of the error along and
        across the true inertial motion and of their squares (px, px2) over pixels that move by 0.1 px at
        least, and the number of these. Profiles add up with `+`.
    """
    import xarray as xr

    truth, strata = true.data, true.strata
    everything = strata.masks["all"]
    errors = _Errors.of(truth, flow, strata)
    found = {}
    for name, explanation in EXPLANATIONS.items():
        value = explanation.of(truth, strata)[everything]
        count = len(explanation.edges) - 1
        # Without the last edge, which is infinite: what is beyond the one before is in the last bin.
        bins = np.digitize(value, explanation.edges[:-1]) - 1
        tables = errors.sorted_into(np.where(np.isnan(value), -1, bins), count)
        dims = (f"bin_{name}", "error_bin"), (f"bin_{name}",), (f"bin_{name}", "moment")
        for what, dim, table in zip(("count", "unmeasured", "sums"), dims, tables, strict=True):
            found[f"{what}_{name}"] = (dim, table)
    return xr.Dataset(found)


@dataclass(frozen=True, eq=False)
class _Errors:
    """Errors of the pixels of a pair: (N,) each; NaN where not measured, or where soil hardly moves."""

    error_bin: np.ndarray
    measured: np.ndarray
    along: np.ndarray
    across: np.ndarray

    @classmethod
    def of(cls, truth: "xr.Dataset", flow: "xr.Dataset", strata: Strata) -> "_Errors":
        chosen = strata.masks["all"]
        u, v = (truth[name].values[chosen].astype(np.float64) for name in "uv")
        off_u, off_v = (flow[name].values[chosen] - true for name, true in (("u", u), ("v", v)))
        if "valid" in flow:
            off_u[~flow["valid"].values[chosen].astype(bool)] = np.nan
        measured = np.isfinite(off_u) & np.isfinite(off_v)
        error = np.nan_to_num(end_point_error(off_u, off_v))
        motion = strata.motion[:, chosen].astype(np.float64)
        speed = np.hypot(*motion)
        with np.errstate(invalid="ignore", divide="ignore"):
            direction_u, direction_v = motion / speed
        directed = measured & (speed >= _DIRECTED)
        along = np.where(directed, off_u * direction_u + off_v * direction_v, np.nan)
        across = np.where(directed, off_v * direction_u - off_u * direction_v, np.nan)
        return cls(np.digitize(error, ERROR_EDGES) - 1, measured, along, across)

    def sorted_into(self, bins: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Counts by error, counts of unmeasured pixels, sums; (N,) `bins` is -1 for pixels left out."""
        kept = (bins >= 0) & self.measured
        width = len(ERROR_EDGES) - 1
        histogram = np.bincount(bins[kept] * width + self.error_bin[kept], minlength=count * width)
        unmeasured = np.bincount(bins[(bins >= 0) & ~self.measured], minlength=count)
        directed = kept & np.isfinite(self.along)
        where, along, across = bins[directed], self.along[directed], self.across[directed]
        moments = (np.ones_like(along), along, across, along**2, across**2)
        sums = [np.bincount(where, weights=one, minlength=count) for one in moments]
        return histogram.reshape(count, width), unmeasured, np.stack(sums, axis=1)


MOMENTS = ("number", "along", "across", "along_squared", "across_squared")
"""Of the dimension `moment`."""


def percentile(histogram: np.ndarray, share: float) -> np.ndarray:
    """Error below which a share of the pixels lies, px, from histograms over ERROR_EDGES: (..., E) to (...).

    Within a bin, errors are taken to be spread evenly over its logarithm; NaN for an empty histogram.
    """
    cumulative = np.cumsum(histogram, axis=-1)
    total = cumulative[..., -1:]
    rank = share * total
    index = np.minimum((cumulative < rank).sum(axis=-1, keepdims=True), histogram.shape[-1] - 1)
    below = np.where(index > 0, np.take_along_axis(cumulative, np.maximum(index - 1, 0), -1), 0)
    held = np.take_along_axis(histogram, index, -1)
    with np.errstate(invalid="ignore", divide="ignore"):
        part = np.where(held > 0, (rank - below) / held, 0.0)
        low, high = ERROR_EDGES[index], ERROR_EDGES[index + 1]
        low = np.where(low > 0, low, high / 2)
        value = np.where(np.isinf(high), low, low * (high / low) ** part)
    return np.where(total > 0, value, np.nan)[..., 0]


def share_above(histogram: np.ndarray, bound: float) -> np.ndarray:
    """Share of the pixels whose error is above a bound, from histograms over ERROR_EDGES: (..., E) to (...).

    The bin that holds the bound is shared out as if its errors were spread evenly; NaN for an empty one.
    """
    inside = np.clip((bound - ERROR_EDGES[:-1]) / np.diff(ERROR_EDGES), 0, 1)
    total = histogram.sum(axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(total > 0, 1 - (histogram * inside).sum(axis=-1) / total, np.nan)
