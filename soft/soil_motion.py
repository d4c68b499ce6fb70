"""What soil does around an implement, in numbers: profile, flux, depth, share along thrust, directions."""

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class VelocityProfile:
    """Mean motion at every depth below a place, as under a wheel.

    Attributes
    ----------
    depth : (N,) float64
        Px below the uppermost soil pixel of the column, 0 for that pixel.
    y : (N,) int
        Row of the picture.
    u, v : (N,) float64
        Mean displacement in px, x right and y down; NaN where nothing was measured.
    spread_u, spread_v : (N,) float64
        Standard deviation over the columns, px.
    count : (N,) int
        Pixels of each mean.
    """

    depth: np.ndarray
    y: np.ndarray
    u: np.ndarray
    v: np.ndarray
    spread_u: np.ndarray
    spread_v: np.ndarray
    count: np.ndarray


@dataclass(frozen=True)
class ThrustShares:
    """How much of the motion goes where: shares of the sum of squared displacements, which add up to 1.

    Soil that is pushed back gives thrust; soil moved up or down costs work and gives none (section 4.1.2).

    Attributes
    ----------
    along : float
        In the direction asked for.
    against : float
        In the opposite direction.
    across : float
        At right angles to it.
    """

    along: float
    against: float
    across: float


@dataclass(frozen=True, eq=False)
class DirectionStatistics:
    """How motion is spread over directions.

    Attributes
    ----------
    edges : (B + 1,) float64
        Bounds of the bins in radians, -pi to pi, counter-clockwise from right, pi/2 is up.
    share : (B,) float64
        Share of the weight in each bin; they add up to 1.
    mean_direction : float
        Direction of the sum of unit vectors, in radians.
    resultant_length : float
        Length of their mean: 1 if all go one way, near 0 if they go every way.
    """

    edges: np.ndarray
    share: np.ndarray
    mean_direction: float
    resultant_length: float


@dataclass(frozen=True)
class Flux:
    """Soil that passes a vertical line, per width of the bin.

    Attributes
    ----------
    forward, backward : float
        Area in a frame that goes over the line forwards, and back: both at least 0.
    net : float
        Their difference.
    unit : str
        `mm2/s` where the scale is known, else `px2/frame`.
    unmeasured : float
        Share of the line's soil that was not measured, and counts nothing.
    """

    forward: float
    backward: float
    net: float
    unit: str
    unmeasured: float


@dataclass(frozen=True)
class FailureDepth:
    """How deep moving soil reaches.

    Attributes
    ----------
    depth : float
        Px from the surface to the lower edge of the deepest moving pixel; 0 where nothing moves.
    x, y : float
        Where that pixel is; NaN where nothing moves.
    """

    depth: float
    x: float
    y: float


def velocity_profile(
    displacement: np.ndarray, soil: np.ndarray, *, x: float, width: float = 11.0
) -> VelocityProfile:
    """Average motion over a narrow strip, at every depth below the uppermost soil at `x`.

    Parameters
    ----------
    displacement : (H, W, 2) array
        Inertial (u, v) in px; NaN where not measured.
    soil : (H, W) bool
        Where soil is.
    x : float
        The strip's middle in px, as the wheel's axle.
    width : float, optional
        The strip's width in px.

    Raises
    ------
    ValueError
        If the strip holds no column of the picture, or there is no soil at `x`.
    """
    columns = np.arange(soil.shape[1])
    inside = np.abs(columns - x) <= width / 2
    middle = round(x)
    if not inside.any() or not 0 <= middle < soil.shape[1]:
        raise ValueError(f"x: {x!r}: must lie in the picture, which is {soil.shape[1]} px wide")
    rows = np.flatnonzero(soil[:, middle])
    if not len(rows):
        raise ValueError(f"x: {x!r}: no soil in this column")
    y = np.arange(rows[0], rows[-1] + 1)
    known = soil & np.isfinite(displacement).all(axis=2)
    strip = np.where(known[:, :, None], displacement, np.nan)[y][:, inside].astype(np.float64)
    count = known[y][:, inside].sum(axis=1)
    mean, spread = _row_statistics(strip, count)
    (u, v), (spread_u, spread_v) = mean.T, spread.T
    return VelocityProfile((y - rows[0]).astype(np.float64), y, u, v, spread_u, spread_v, count)


def _row_statistics(strip: np.ndarray, count: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean and standard deviation (N, 2) over the columns of (N, C, 2); NaN where there is none."""
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.nansum(strip, axis=1) / count[:, None]
        square = np.nansum(np.square(strip - mean[:, None]), axis=1) / count[:, None]
    return mean, np.sqrt(square)


def thrust_shares(
    displacement: np.ndarray, region: np.ndarray, *, direction: tuple[float, float] = (-1.0, 0.0)
) -> ThrustShares:
    """Split the squared displacement of a region into along, against and across a direction.

    Parameters
    ----------
    displacement : (H, W, 2) array
        Inertial (u, v) in px, x right and y down; pixels that are NaN are left out.
    region : (H, W) bool
        The soil to look at, as the moving region.
    direction : (float, float), optional
        Where soil goes that gives thrust, x right and y down; to the left by default, as under a wheel that
        drives to the right. Its length does not matter.

    Raises
    ------
    ValueError
        If `direction` is zero, or nothing in the region moves.
    """
    axis = np.asarray(direction, np.float64)
    length = float(np.hypot(*axis))
    if not 0 < length < math.inf:
        raise ValueError(f"direction: {direction!r}: must not be zero")
    vectors = _vectors(displacement, region)
    total = float(np.square(vectors).sum())
    if total == 0:
        raise ValueError("region: nothing in it moves: there is nothing to share")
    component = vectors @ (axis / length)
    along = float(np.square(component[component > 0]).sum()) / total
    against = float(np.square(component[component < 0]).sum()) / total
    return ThrustShares(along, against, 1.0 - along - against)


def direction_statistics(
    displacement: np.ndarray, region: np.ndarray, *, bin_count: int = 36, by_speed: bool = False
) -> DirectionStatistics:
    """Count directions of motion in a region, and tell how far they agree.

    Parameters
    ----------
    displacement : (H, W, 2) array
        Inertial (u, v) in px, x right and y down; pixels that are NaN or zero are left out.
    region : (H, W) bool
        The soil to look at, as the moving region.
    bin_count : int, optional
        Bins of equal width.
    by_speed : bool, optional
        Weigh each pixel by its speed; by default all count alike.

    Raises
    ------
    ValueError
        If there is no bin, or nothing in the region moves.
    """
    if bin_count < 1:
        raise ValueError(f"bin_count: {bin_count!r}: must be at least 1")
    vectors = _vectors(displacement, region)
    speed = np.hypot(vectors[:, 0], vectors[:, 1])
    vectors, speed = vectors[speed > 0], speed[speed > 0]
    if not len(speed):
        raise ValueError("region: nothing in it moves: there is no direction")
    weight = speed / speed.sum() if by_speed else np.full(len(speed), 1 / len(speed))
    # Up is where y decreases.
    angle = np.arctan2(-vectors[:, 1], vectors[:, 0])
    share, edges = np.histogram(angle, bins=bin_count, range=(-np.pi, np.pi), weights=weight)
    x, z = (weight * np.cos(angle)).sum(), (weight * np.sin(angle)).sum()
    return DirectionStatistics(edges, share, float(np.arctan2(z, x)), float(np.hypot(x, z)))


def forward_flux(
    displacement: np.ndarray,
    soil: np.ndarray,
    *,
    x: float,
    forward: int = 1,
    metres_per_pixel: float | None = None,
    frame_rate: float | None = None,
) -> Flux:
    """Soil that passes the vertical line at `x`, as just ahead of a wheel: its forward flow resists.

    Parameters
    ----------
    displacement : (H, W, 2) array
        Inertial (u, v) in px a frame; NaN where not measured.
    soil : (H, W) bool
        Where soil is.
    x : float
        The column in px; the nearest pixel's is taken.
    forward : int, optional
        1: forward is to the right, -1: to the left.
    metres_per_pixel, frame_rate : float, optional
        With both, the flux is told in mm2/s.

    Raises
    ------
    ValueError
        If the line lies outside the picture, or `forward` is neither.
    """
    if forward not in (1, -1):
        raise ValueError(f"forward: {forward!r}: allowed are 1 (right) and -1 (left)")
    column = round(x)
    if not 0 <= column < soil.shape[1]:
        raise ValueError(f"x: {x!r}: must lie in the picture, which is {soil.shape[1]} px wide")
    on_line = forward * displacement[soil[:, column], column, 0].astype(np.float64)
    known = np.isfinite(on_line)
    scale, unit = 1.0, "px2/frame"
    if metres_per_pixel is not None and frame_rate is not None:
        scale, unit = float((1e3 * metres_per_pixel) ** 2 * frame_rate), "mm2/s"
    ahead, back = (float(np.maximum(way * on_line[known], 0).sum()) * scale for way in (1, -1))
    return Flux(ahead, back, ahead - back, unit, float(1 - known.mean()) if len(known) else 0.0)


def failure_depth(moving: np.ndarray, soil: np.ndarray, *, surface_y: float | None = None) -> FailureDepth:
    """How far below the surface soil moves.

    Parameters
    ----------
    moving : (H, W) bool
        The moving region.
    soil : (H, W) bool
        Where soil is.
    surface_y : float, optional
        Row of the undisturbed surface in px, from which depth is counted. By default the uppermost soil of
        each column is the surface: the implement's lower side where it touches.
    """
    inside = moving & soil
    columns = np.flatnonzero(inside.any(axis=0))
    if not len(columns):
        return FailureDepth(0.0, math.nan, math.nan)
    lowest = soil.shape[0] - 1 - np.argmax(inside[::-1, columns], axis=0)
    top = np.argmax(soil[:, columns], axis=0) - 0.5 if surface_y is None else surface_y
    depth = lowest + 0.5 - top
    deepest = int(np.argmax(depth))
    return FailureDepth(max(float(depth[deepest]), 0.0), float(columns[deepest]), float(lowest[deepest]))


def _vectors(displacement: np.ndarray, region: np.ndarray) -> np.ndarray:
    """Known vectors (N, 2) of a region."""
    if displacement.shape != (*region.shape, 2):
        raise ValueError(f"region: shape {region.shape}: must be {displacement.shape[:2]}")
    inside = displacement[region].astype(np.float64)
    return inside[np.isfinite(inside).all(axis=1)]
