"""One field of motion as a figure shows it: every n-th pixel, in the units of the page."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from soft.figures.units import Units
from soft.velocity import to_polar, to_velocity

if TYPE_CHECKING:
    import xarray

    from soft.shear_interface import ShearInterface

# More pixels than this a side are not told apart on a page.
DISPLAY_SIDE = 1400

# The colour scale ends at this percentile of the speeds, as a few wrong vectors would set it otherwise.
TOP_PERCENTILE = 99.5

Extent = tuple[float, float, float, float]


@dataclass(frozen=True, eq=False)
class View:
    """Motion of soil over a picture. Displayed vectors are samples, never averages of magnitudes.

    Attributes
    ----------
    picture : (h, w) array
        Grey, 0-255, every n-th pixel.
    x, z : (h, w) array
        Motion to the right and up, in the speed unit; NaN where there is none to show.
    soil, moving : (h, w) bool
        Where soil is, and its moving region; all False where none was found.
    units : Units
        What the numbers are.
    extent : tuple
        Left, right, bottom, top of the picture in the length unit, y down.
    lines : tuple of (N, 2) array, or None
        The shear interface in px where it was measured; None: the moving region's outline stands for it.
    """

    picture: np.ndarray
    x: np.ndarray
    z: np.ndarray
    soil: np.ndarray
    moving: np.ndarray
    units: Units
    extent: Extent
    lines: tuple[np.ndarray, ...] | None = None

    @property
    def speed(self) -> np.ndarray:
        """Magnitude, in the speed unit."""
        return to_polar(self.x, self.z)[0]

    @property
    def direction(self) -> np.ndarray:
        """Angle within the moving region, rad, counter-clockwise from right: outside it has no meaning."""
        return np.where(self.moving, to_polar(self.x, self.z)[1], np.nan)

    @property
    def places(self) -> tuple[np.ndarray, np.ndarray]:
        """Where the columns (w,) and rows (h,) lie, in the length unit."""
        left, right, bottom, top = self.extent
        rows, columns = self.moving.shape
        x = left + (np.arange(columns) + 0.5) * (right - left) / columns
        return x, top + (np.arange(rows) + 0.5) * (bottom - top) / rows


def view_of_pair(
    flow: "xarray.Dataset",
    picture: np.ndarray,
    pair: int,
    interface: "ShearInterface | None" = None,
) -> View:
    """One pair of a SoilFlow in the inertial frame, over its first picture (H, W)."""
    arrays = flow[["inertial_u", "inertial_v", "valid", "soil", "moving"]].isel(pair=pair)
    shown = (arrays["valid"] & arrays["soil"]).to_numpy()
    u, v = (np.where(shown, arrays[name].to_numpy(), np.nan) for name in ("inertial_u", "inertial_v"))
    if "node_x" in flow:
        u, v = (np.where(arrays["soil"], cells(one), np.nan) for one in (u, v))
    return view_of_motion(
        u,
        v,
        picture,
        soil=arrays["soil"].to_numpy(),
        moving=arrays["moving"].to_numpy(),
        units=Units.of_flow(flow, pair),
        interface=interface,
    )


def view_of_motion(
    u: np.ndarray,
    v: np.ndarray,
    picture: np.ndarray,
    *,
    soil: np.ndarray,
    moving: np.ndarray,
    units: Units,
    interface: "ShearInterface | None" = None,
) -> View:
    """Any field of motion (H, W), px right and down, over a picture (H, W); NaN is not shown.

    Parameters
    ----------
    soil, moving : (H, W) bool
        Where soil is, and its moving region.
    units : Units
        Of the page.
    interface : ShearInterface, optional
        The line between moving and resting soil.
    """
    stride = stride_of(picture.shape)
    displacement = reduced(np.stack([u, v], axis=-1), stride)
    x, z = to_velocity(displacement, metres_per_pixel=units.speed, time_step=1.0)
    return View(
        picture=smoothed(picture, stride),
        x=x,
        z=z,
        soil=reduced(soil, stride),
        moving=reduced(moving, stride),
        units=units,
        extent=extent_of(picture.shape, units),
        lines=None if interface is None else interface.lines,
    )


def cells(values: np.ndarray) -> np.ndarray:
    """Give each pixel (H, W) the value of the nearest one that is not NaN, as far as half-way to the next.

    The nodes of a grid fill the picture so, and each is seen as what it was measured as; where one was not
    measured, a hole is left.
    """
    from scipy.ndimage import distance_transform_cdt
    from scipy.spatial import KDTree

    held = np.argwhere(np.isfinite(values))
    if len(held) < 2:
        return values
    spacing = np.median(KDTree(held).query(held, k=2)[0][:, 1])
    distance, (row, column) = distance_transform_cdt(
        np.isnan(values), metric="chessboard", return_indices=True
    )
    return np.where(distance <= spacing / 2, values[row, column], np.nan)


def stride_of(shape: tuple[int, ...]) -> int:
    """Every how many pixels one is shown."""
    return -(-max(shape[:2]) // DISPLAY_SIDE)


def reduced(values: np.ndarray, stride: int) -> np.ndarray:
    """Every n-th pixel, the middle one of n, of (H, W, ...) values."""
    return values[stride // 2 :: stride, stride // 2 :: stride]


def smoothed(picture: np.ndarray, stride: int) -> np.ndarray:
    """A picture (H, W) of the size of `reduced` values, by averages, which grey levels may be."""
    import cv2

    if stride == 1:
        return picture
    size = tuple(len(range(stride // 2, side, stride)) for side in picture.shape)
    return cv2.resize(picture, size[::-1], interpolation=cv2.INTER_AREA)


def extent_of(shape: tuple[int, ...], units: Units) -> Extent:
    """Left, right, bottom, top of a picture for `imshow`, y down, with pixel centres at whole px."""
    scale = units.length
    return (-0.5 * scale, (shape[1] - 0.5) * scale, (shape[0] - 0.5) * scale, -0.5 * scale)


def top_of(*values: np.ndarray) -> float:
    """Where a colour scale for all of these ends; 1 where nothing moves."""
    finite = np.concatenate([one[np.isfinite(one)] for one in values])
    top = float(np.percentile(finite, TOP_PERCENTILE)) if finite.size else 0.0
    return top if top > 0 else 1.0
