"""The shear interface: the line between moving and resting soil (section 2.3, Fig. 4)."""

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from soft.pair_motion import motion_between_nodes
from soft.segmentation import MovingRegion, moving_mask, texture_size, without_gaps

if TYPE_CHECKING:
    import xarray

    from soft.averaging import MeanFlow

# px. The soil's outline is known to about this much; what runs along it closer than that follows the
# implement or the free surface, and is no boundary between two soils.
OUTLINE_MARGIN = 3.0


@dataclass(frozen=True, eq=False)
class ShearInterface:
    """Where moving soil borders on resting soil.

    Attributes
    ----------
    lines : tuple of (N, 2) float64 arrays
        x, y in px of the first picture, in order along each line. The moving region lies on the same side all
        along; a line whose first and last points are the same is closed.
    remark : str
        What was found, in words.
    """

    lines: tuple[np.ndarray, ...]
    remark: str

    @property
    def length(self) -> float:
        """Length of all lines in px."""
        return float(sum(np.hypot(*np.diff(line, axis=0).T).sum() for line in self.lines))


def shear_interface(
    speed: np.ndarray,
    moving: np.ndarray,
    *,
    threshold: float,
    soil: np.ndarray | None = None,
    margin: float = OUTLINE_MARGIN,
) -> ShearInterface:
    """Find the boundary of the moving region within soil, to a fraction of a pixel.

    The boundary runs between a pixel in the region and a neighbour that is not. Between the two centres it
    lies where the speed, taken to change linearly, is the threshold; half-way where both are on the same side
    of it, as where a gap was filled. Stretches along the implement, the free surface or the picture's border
    close the region off and are left out, and so are those along soil whose motion was not measured: whether
    it moves is not known.

    Parameters
    ----------
    speed : (H, W) array
        Magnitude of inertial displacement in px, NaN where it was not measured.
    moving : (H, W) bool
        The moving region, as of `moving_mask`.
    threshold : float
        Speed in px that parts moving from resting soil, as `moving_mask` tells it.
    soil : (H, W) bool, optional
        Where soil is; where the speed was measured by default.
    margin : float, optional
        Boundary at most this many px from a pixel that is not soil, or was not measured, is left out; gaps
        that a moving region reaches over do not count.

    Raises
    ------
    ValueError
        If shapes differ.
    """
    soil = np.isfinite(speed) if soil is None else soil
    if not speed.shape == moving.shape == soil.shape:
        raise ValueError(f"moving: shape {moving.shape}: must be that of speed and soil, {speed.shape}")
    if not moving.any():
        return ShearInterface((), "no moving region, so no shear interface")
    known = soil & without_gaps(np.isfinite(speed), size=texture_size(speed.shape))
    inner = _distance_to_outline(known) > margin
    lines: list[np.ndarray] = []
    for boundary in _boundaries(moving):
        kept, placed = _placed(boundary, speed, threshold, inner)
        lines += _runs(placed, kept)
    if not lines:
        return ShearInterface((), "the moving region borders on no resting soil in view")
    found = ShearInterface(tuple(lines), "")
    count = f"{len(lines)} line{'s' if len(lines) > 1 else ''}"
    return ShearInterface(found.lines, f"shear interface of {count}, {found.length:.0f} px long")


def shear_interface_of(flow: "xarray.Dataset", *, pair: int = 0) -> ShearInterface:
    """Find the shear interface of one pair of a SoilFlow; that of a grid by motion linear between its nodes.

    Parameters
    ----------
    flow : xarray.Dataset
        A SoilFlow.
    pair : int, optional
        Which pair.
    """
    motion = motion_between_nodes(flow, pair)
    seed = int(flow.attrs.get("seed", 0))
    region = moving_mask(motion.speed, motion.soil, seed=seed, reach=motion.spacing)
    # Beyond a grid's outermost nodes nothing is known, so the region's edge there is no boundary.
    return _around(region, motion.speed, motion.measured if motion.spacing else motion.soil)


def shear_interface_of_mean(mean: "MeanFlow", *, seed: int = 0) -> ShearInterface:
    """Find the shear interface of an average over pairs; motion may show that single pairs do not show."""
    soil = np.isfinite(mean.speed) if mean.spacing else mean.soil
    return _around(mean.moving_region(seed=seed), mean.speed, soil)


def _around(region: MovingRegion, speed: np.ndarray, soil: np.ndarray) -> ShearInterface:
    if not region.found:
        return ShearInterface((), region.remark)
    return shear_interface(speed, region.mask, threshold=region.threshold, soil=soil)


def write_interface(
    interface: ShearInterface, path: str | Path, *, metres_per_pixel: float | None = None
) -> None:
    """Write the lines as CSV: number of the line, x and y in px, and in m with a pixel size.

    Parameters
    ----------
    interface : ShearInterface
        What to write.
    path : str or Path
        The file.
    metres_per_pixel : float, optional
        Pixel size in m; x right and y down from the centre of the first pixel, as in px.
    """
    header = ["line", "x_px", "y_px"] + (["x_m", "y_m"] if metres_per_pixel else [])
    with Path(path).open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        for number, line in enumerate(interface.lines):
            for x, y in line:
                metres = [f"{c * metres_per_pixel:.7g}" for c in (x, y)] if metres_per_pixel else []
                writer.writerow([number, f"{x:.3f}", f"{y:.3f}", *metres])


def _distance_to_outline(soil: np.ndarray) -> np.ndarray:
    """Px from each pixel's centre to the nearest one that is not soil; infinite where all is soil."""
    from scipy.ndimage import distance_transform_edt

    return np.full(soil.shape, np.inf) if soil.all() else np.asarray(distance_transform_edt(soil))


def _boundaries(region: np.ndarray) -> list[np.ndarray]:
    """Lines half-way between the centres of pixels in a region and of neighbours out of it: (N, 2) x, y."""
    from contourpy import contour_generator

    lines = contour_generator(z=region.astype(np.float64), name="serial").lines(0.5)
    return [np.asarray(line, np.float64) for line in lines]


def _placed(
    boundary: np.ndarray, speed: np.ndarray, threshold: float, inner: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Shift vertices, (N, 2) x and y half-way between two centres, to where the speed crosses.

    Returns
    -------
    kept : (N,) bool
        Whether both centres lie in the soil's inside.
    placed : (N, 2) array
        x and y in px.
    """
    one, other = np.floor(boundary).astype(np.intp), np.ceil(boundary).astype(np.intp)
    at_one, at_other = (speed[ends[:, 1], ends[:, 0]] - threshold for ends in (one, other))
    with np.errstate(invalid="ignore", divide="ignore"):
        crosses = (at_one * at_other <= 0) & (at_one != at_other)
        fraction = np.where(crosses, at_one / (at_one - at_other), 0.5)
    kept = inner[one[:, 1], one[:, 0]] & inner[other[:, 1], other[:, 0]]
    return kept, one + fraction[:, None] * (other - one)


def _runs(points: np.ndarray, kept: np.ndarray) -> list[np.ndarray]:
    """Stretches of at least two points in a row that are kept; a closed line is cut where it is not."""
    if kept.all():
        return [points] if len(points) > 1 else []
    if len(points) > 1 and np.array_equal(points[0], points[-1]):
        start = int(np.argmin(kept))
        points, kept = (np.concatenate([a[start:-1], a[: start + 1]]) for a in (points, kept))
    edges = np.flatnonzero(np.diff(np.concatenate([[False], kept, [False]]).astype(np.int8)))
    return [points[a:b] for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a > 1]
