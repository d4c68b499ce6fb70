"""How well soil, its moving part and the line between moving and resting soil are found.

Distances of the shear interface are told two ways. To the interface that the same clustering finds in the
true speeds: what remains is the measurement's doing. And to the line of greatest true shear rate: what the
clustering itself is off by, when its line is taken for the place where soil shears.
"""

from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.scoring.line_distance import distances, points_along
from validation.scoring.shear_line import shear_line
from validation.scoring.strata import Strata

if TYPE_CHECKING:
    import xarray as xr

    from soft import MovingRegion, ShearInterface
    from validation.scoring.truth_pass import TruePair

_NEEDED_OF_FLOW = ("u", "v", "inertial_u", "inertial_v", "valid", "soil", "moving")


@dataclass(frozen=True)
class RegionScore:
    """Over all picture pairs; None where there is nothing to tell.

    Attributes
    ----------
    soil_iou : float or None
        Pixels that are soil by both truth and measurement over those that are by either.
    moving_iou : float or None
        The same of the moving region, in truth as clustered from the true speeds.
    interface_pair_count : int
        Pairs in which truth and measurement both have a shear interface: distances are of these.
    interface_missed_count, interface_false_count : int
        Pairs in which only the truth has one, only the measurement.
    interface_mean, interface_p95 : float or None
        Distance from points of the measured interface to the true one, px.
    interface_symmetric_mean, interface_symmetric_p95 : float or None
        The same with the distances from the true to the measured one put with them, px.
    interface_true_camera_mean, interface_true_camera_p95 : float or None
        As `interface_mean`, `interface_p95`, had the camera's motion been known: what is left of the error is
        that of flow.
    shear_line_mean, shear_line_p95 : float or None
        Distance from the line of greatest true shear rate to the measured interface, px.
    shear_line_true_mean, shear_line_true_p95 : float or None
        From the same line to the true interface, px: what no measurement could better.
    """

    soil_iou: float | None
    moving_iou: float | None
    interface_pair_count: int
    interface_missed_count: int
    interface_false_count: int
    interface_mean: float | None
    interface_p95: float | None
    interface_symmetric_mean: float | None
    interface_symmetric_p95: float | None
    interface_true_camera_mean: float | None
    interface_true_camera_p95: float | None
    shear_line_mean: float | None
    shear_line_p95: float | None
    shear_line_true_mean: float | None
    shear_line_true_p95: float | None

    def to_dict(self) -> dict[str, Any]:
        """As it stands in scores.json, beside the method's other numbers."""
        return asdict(self)


@dataclass(frozen=True, eq=False)
class TrueRegions:
    """What is true of one picture pair.

    Attributes
    ----------
    soil, moving : (H, W) bool
        Soil, and the moving region as clustered from the true inertial speeds.
    interface, shear_line : (N, 2) float64
        Points x, y in px of the shear interface, at even steps, and of the line of greatest shear rate.
    camera : (float, float)
        Displacement of resting soil by the camera's motion, right and down, px.
    """

    soil: np.ndarray
    moving: np.ndarray
    interface: np.ndarray
    shear_line: np.ndarray
    camera: tuple[float, float]


@dataclass
class RegionTally:
    """Sums and distances of one method, pair by pair."""

    soil: np.ndarray = field(default_factory=lambda: np.zeros(2, np.int64))
    moving: np.ndarray = field(default_factory=lambda: np.zeros(2, np.int64))
    counts: dict[str, int] = field(default_factory=lambda: {"both": 0, "missed": 0, "false": 0})
    to_true: list[np.ndarray] = field(default_factory=list)
    from_true: list[np.ndarray] = field(default_factory=list)
    by_true_camera: list[np.ndarray] = field(default_factory=list)
    to_shear: list[np.ndarray] = field(default_factory=list)
    to_shear_true: list[np.ndarray] = field(default_factory=list)

    @staticmethod
    def suits(flow: "xr.Dataset") -> bool:
        """Whether a method tells masks at all."""
        return set(_NEEDED_OF_FLOW) <= set(flow.data_vars)

    def add(self, pair: "TruePair", flow: "xr.Dataset") -> None:
        """Add one pair of a SoilFlow, over `y, x`."""
        true = pair.regions
        soil = flow["soil"].values.astype(bool)
        self.soil += [(soil & true.soil).sum(), (soil | true.soil).sum()]
        moving = flow["moving"].values.astype(bool)
        self.moving += [(moving & true.moving).sum(), (moving | true.moving).sum()]
        self._add_interface(true, _measured_interface(flow))
        if len(true.interface) and len(found := _measured_interface(_seen_from(true.camera, flow))):
            self.by_true_camera.append(distances(found, true.interface))

    def _add_interface(self, true: TrueRegions, found: np.ndarray) -> None:
        if len(found) and len(true.interface):
            self.counts["both"] += 1
            self.to_true.append(distances(found, true.interface))
            self.from_true.append(distances(true.interface, found))
            self.to_shear.append(distances(true.shear_line, found))
            self.to_shear_true.append(distances(true.shear_line, true.interface))
        elif len(true.interface):
            self.counts["missed"] += 1
        elif len(found):
            self.counts["false"] += 1

    def result(self) -> RegionScore:
        """Over all pairs added."""
        both_ways = _mean_and_p95(self.to_true + self.from_true)
        one_way, by_true_camera, shear, shear_true = (
            _mean_and_p95(parts)
            for parts in (self.to_true, self.by_true_camera, self.to_shear, self.to_shear_true)
        )
        return RegionScore(
            soil_iou=_ratio(self.soil),
            moving_iou=_ratio(self.moving),
            interface_pair_count=self.counts["both"],
            interface_missed_count=self.counts["missed"],
            interface_false_count=self.counts["false"],
            interface_mean=one_way[0],
            interface_p95=one_way[1],
            interface_symmetric_mean=both_ways[0],
            interface_symmetric_p95=both_ways[1],
            interface_true_camera_mean=by_true_camera[0],
            interface_true_camera_p95=by_true_camera[1],
            shear_line_mean=shear[0],
            shear_line_p95=shear[1],
            shear_line_true_mean=shear_true[0],
            shear_line_true_p95=shear_true[1],
        )


def true_regions(truth: "xr.Dataset", strata: Strata) -> TrueRegions:
    """Find regions and lines of one picture pair in its truth.

    Parameters
    ----------
    truth : xarray.Dataset
        Over `y, x`, as of `synth.Footage.truth`.
    strata : Strata
        Its own.
    """
    soil = truth["soil"].values.astype(bool)
    region, interface = _true_moving(truth, strata)
    shears = region.found and "strain_rate" in truth
    crest = shear_line(truth["strain_rate"].values, soil) if shears else np.empty((0, 2))
    camera = strata.camera_u, strata.camera_v
    return TrueRegions(soil, region.mask, points_along(interface.lines), crest, camera)


def true_interface(truth: "xr.Dataset", strata: Strata) -> "ShearInterface":
    """Find the shear interface alone, as `true_regions` does, in the true speeds."""
    return _true_moving(truth, strata)[1]


def _true_moving(truth: "xr.Dataset", strata: Strata) -> "tuple[MovingRegion, ShearInterface]":
    from soft import moving_mask
    from soft.shear_interface import shear_interface

    soil = truth["soil"].values.astype(bool)
    region = moving_mask(strata.speed, soil)
    return region, shear_interface(strata.speed, region.mask, threshold=region.threshold, soil=soil)


def _measured_interface(flow: "xr.Dataset") -> np.ndarray:
    """Points of the interface of one pair at even steps, x, y in px."""
    from soft import shear_interface_of

    return points_along(shear_interface_of(flow.expand_dims("pair")).lines)


def _seen_from(camera: tuple[float, float], flow: "xr.Dataset") -> "xr.Dataset":
    """Take another camera motion out of one pair of a SoilFlow."""
    return flow.assign(inertial_u=flow["u"] - camera[0], inertial_v=flow["v"] - camera[1])


def _ratio(sums: np.ndarray) -> float | None:
    return float(sums[0] / sums[1]) if sums[1] else None


def _mean_and_p95(parts: list[np.ndarray]) -> tuple[float | None, float | None]:
    values = np.concatenate(parts) if parts else np.empty(0)
    if not values.size:
        return None, None
    return float(values.mean()), float(np.percentile(values, 95))
