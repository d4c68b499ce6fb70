"""One picture pair with its truth and its measurements, as a report shows it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from validation.scoring.metrics import end_point_error
from validation.scoring.nodes import difference_at, has_node, stacked
from validation.scoring.strata import Strata, find_strata
from validation.scoring.truth_pass import TruePair

DIRECTION_ABOVE = 0.3
"""px a frame; slower soil has no direction worth a colour."""

if TYPE_CHECKING:
    import xarray as xr

    from soft.figures.units import Units
    from validation.material import Material
    from validation.methods import Method
    from validation.run_folder import RunFolder


def middle_pair(count: int) -> int:
    """The pair that is shown where none is asked for, of so many."""
    return (count - 1) // 2


@dataclass(frozen=True, eq=False)
class Motion:
    """Motion of soil in the inertial frame.

    Attributes
    ----------
    u, v : (H, W) array
        Displacement, px a frame, x right and y down; NaN where there is no soil or it is not known.
    """

    u: np.ndarray
    v: np.ndarray

    @property
    def speed(self) -> np.ndarray:
        """Magnitude, px a frame."""
        return np.hypot(self.u, self.v)

    @property
    def direction(self) -> np.ndarray:
        """Angle, rad, counter-clockwise from right as the picture shows it: pi/2 is up."""
        from soft import to_polar, to_velocity

        upwards = to_velocity(np.stack([self.u, self.v], axis=-1), metres_per_pixel=1.0, time_step=1.0)
        return to_polar(*upwards)[1]

    @property
    def shown_direction(self) -> np.ndarray:
        """Direction where soil is fast enough to have one worth a colour, NaN elsewhere."""
        with np.errstate(invalid="ignore"):
            return np.where(self.speed > DIRECTION_ABOVE, self.direction, np.nan)


@dataclass(frozen=True, eq=False)
class Measured:
    """What one method measured of the pair.

    Attributes
    ----------
    motion : Motion
        As the method says: its own soil, its own camera motion.
    error : (H, W) array
        End-point error, px, over true soil; NaN elsewhere and where not measured.
    missed : (H, W) bool array
        True soil that was not measured.
    camera_u : float
        Horizontal displacement by the camera's own motion, as the analysis found it, px.
    soil : (H, W) bool array
        True soil.
    gridded : bool
        Whether it tells of a grid's nodes only: of other pixels, nothing is missed.
    """

    motion: Motion
    error: np.ndarray
    missed: np.ndarray
    camera_u: float
    soil: np.ndarray
    gridded: bool = False

    def shown(self, values: np.ndarray) -> np.ndarray:
        """Values (H, W) as a figure shows them: a node of a grid fills its cell, within soil."""
        from soft.figures.view import cells

        return np.where(self.soil, cells(values), np.nan) if self.gridded else values


@dataclass(frozen=True, eq=False)
class PairView:
    """One picture pair.

    Attributes
    ----------
    pair : int
        Its number.
    picture : (H, W) array
        The first picture, grey levels 0-255.
    truth : Motion
        What the soil did.
    strata : dict
        The (H, W) bool masks of `validation.scoring.strata`.
    measured : dict
        By method's name.
    camera_u : float
        True horizontal displacement by the camera's own motion, px.
    units : soft.figures.units.Units
        Of the pictures.
    """

    pair: int
    picture: np.ndarray
    truth: Motion
    strata: dict[str, np.ndarray]
    measured: dict[str, Measured]
    camera_u: float
    units: "Units"


def read_true_pair(material: "Material", pair: int) -> TruePair:
    """Read the truth of one pair of footage."""
    import synth

    with synth.Footage.open(material.folder) as footage:
        return TruePair(footage.truth(pair).load())


def view_pair(
    run: "RunFolder",
    material: "Material",
    methods: "Sequence[Method]",
    pair: int,
    *,
    true: TruePair | None = None,
) -> PairView:
    """Read one pair of a scored run; its truth, too, unless that was read before."""
    import soft
    from soft.figures.units import Units

    true = true or read_true_pair(material, pair)
    found = true.strata
    measured = {}
    for method in methods:
        with soft.read_soil_flow(run.analysis(method.slug)) as flow:
            one = flow.isel(pair=pair).load()
            measured[method.name] = _measured(one, true.data, found.masks["all"])
    sequence = material.sequence
    units = Units.of(metres_per_pixel=sequence.metres_per_pixel, frame_rate=sequence.frame_rate)
    motion = Motion(*found.motion)
    return PairView(pair, sequence[pair], motion, found.masks, measured, found.camera_u, units)


def true_motion(truth: "xr.Dataset", found: Strata | None = None) -> Motion:
    """What the soil of one pair did, from its truth (over `y, x`) and, where they are known, its strata."""
    return Motion(*(found or find_strata(truth)).motion)


def _measured(flow: "xr.Dataset", truth: "xr.Dataset", here: np.ndarray) -> Measured:
    from soft.figures.view import cells

    said = flow["soil"].values.astype(bool) & flow["valid"].values.astype(bool)
    u, v = (np.where(said, flow[name].values, np.nan) for name in ("inertial_u", "inertial_v"))
    judged = here & flow["valid"].values.astype(bool)
    nodes = stacked(flow, "node_x", "node_y") if "node_x" in flow else None
    difference = difference_at(stacked(flow, "u", "v"), stacked(truth, "u", "v").astype(float), nodes)
    error = np.where(judged, end_point_error(difference[..., 0], difference[..., 1]), np.nan)
    told = here if nodes is None else here & has_node(nodes)
    if nodes is not None:
        soil = flow["soil"].values.astype(bool)
        u, v = (np.where(soil, cells(one), np.nan) for one in (u, v))
    missed = told & ~np.isfinite(error)
    return Measured(Motion(u, v), error, missed, float(flow["camera_u"]), here, gridded=nodes is not None)
