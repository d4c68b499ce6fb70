"""The glass as the camera sees it: pixel size and tilt from points on it, and pictures seen square to it."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from soft.calibration.error import CalibrationError
from soft.calibration.lens import Lens, mapped_grid
from soft.sequence.resampling import Resampling

LEAST_POINTS = 4

_WEAKEST = 1e-5
"""Least of the eight singular values that a homography needs, over the largest: below, points are in line."""

_LARGEST = 4.0
"""Pixels of a picture seen square, over those of the camera's: more is from looking along the glass."""


@dataclass(frozen=True, eq=False)
class GlassCalibration:
    """Where points of the glass are in the picture.

    Attributes
    ----------
    shape : (int, int)
        Rows and columns of the camera's pictures.
    homography : (3, 3) float64
        From (x, z) on the glass in m, x along the bin and z up, to px without the lens's distortion.
    lens : Lens or None
        None: one without distortion.
    residual : float
        Root mean square distance of the points from where they should be, px; 0 with four points.
    residual_max : float
        The largest, px.
    point_count : int
    """

    shape: tuple[int, int]
    homography: np.ndarray
    lens: Lens | None
    residual: float
    residual_max: float
    point_count: int

    def to_pixels(self, points: np.ndarray) -> np.ndarray:
        """Where points (N, 2) of the glass in m are in the camera's picture, (N, 2) px."""
        pixels = _projected(self.homography, points)
        return pixels if self.lens is None else self.lens.distorted(pixels)

    def to_glass(self, points: np.ndarray) -> np.ndarray:
        """Where points (N, 2) px of the camera's picture are on the glass, (N, 2) m."""
        pixels = np.asarray(points, np.float64) if self.lens is None else self.lens.undistorted(points)
        return _projected(np.linalg.inv(self.homography), pixels)

    @cached_property
    def metres_per_pixel(self) -> float:
        """Pixel size at the picture's centre in m, the root of a pixel's area."""
        return float(self._scale(np.array([[(self.shape[1] - 1) / 2, (self.shape[0] - 1) / 2]]))[0])

    @cached_property
    def scale_spread(self) -> float:
        """Largest less smallest pixel size in the picture's corners and centre / that at the centre.

        What one pixel size for the whole picture gets wrong, unless the pictures are rectified.
        """
        height, width = self.shape
        x, y = (np.array([0, 1, 0, 1, 0.5]) * (width - 1), np.array([0, 0, 1, 1, 0.5]) * (height - 1))
        sizes = self._scale(np.stack([x, y], axis=1))
        return float(np.ptp(sizes)) / self.metres_per_pixel

    @cached_property
    def tilt(self) -> float | None:
        """Angle between the optical axis and the normal of the glass in rad; None without a lens."""
        if self.lens is None:
            return None
        axes = np.linalg.inv(self.lens.camera_matrix) @ self.homography
        normal = np.cross(axes[:, 0], axes[:, 1])
        return float(np.arccos(min(1.0, abs(normal[2]) / np.linalg.norm(normal))))

    def rectification(self, metres_per_pixel: float | None = None) -> "Rectification":
        """See the glass square: x of the picture along the bin, y down, every pixel of one size.

        Parameters
        ----------
        metres_per_pixel : float, optional
            Of the new pictures, in m; by default that at the centre of the camera's.

        Raises
        ------
        CalibrationError
            If the camera looks along the glass, so that the picture would be vast.
        """
        size = self.metres_per_pixel if metres_per_pixel is None else metres_per_pixel
        outline = self._outline()
        (left, bottom), (right, top) = outline.min(axis=0), outline.max(axis=0)
        columns, rows = (int(np.ceil(length / size)) + 1 for length in (right - left, top - bottom))
        if columns * rows > _LARGEST * self.shape[0] * self.shape[1]:
            raise CalibrationError(
                f"the glass is seen too obliquely: {columns} x {rows} px would be needed to see it square "
                f"at {size:.3g} m/px"
            )
        corner = np.array([left, top])
        source = mapped_grid(
            (rows, columns), lambda grid: self.to_pixels(corner + grid * np.array([size, -size]))
        )
        return Rectification(Resampling(source, self.shape), size, float(left), float(top))

    def _outline(self) -> np.ndarray:
        """Border of the picture on the glass, (N, 2) m."""
        height, width = self.shape
        x, y = np.arange(width), np.arange(height)
        border = np.concatenate(
            [np.stack([x, np.full(width, edge)], axis=1) for edge in (0, height - 1)]
            + [np.stack([np.full(height, edge), y], axis=1) for edge in (0, width - 1)]
        )
        pixels = border if self.lens is None else self.lens.undistorted(border)
        depth = (
            np.concatenate([pixels, np.ones((len(pixels), 1))], axis=1) @ np.linalg.inv(self.homography)[2]
        )
        if depth.min() * depth.max() <= 0:
            raise CalibrationError("the glass is seen too obliquely: its horizon lies in the picture")
        return self.to_glass(border)

    def _scale(self, points: np.ndarray) -> np.ndarray:
        """Pixel size at points (N, 2) px of the camera's picture, m."""
        right, below = np.array([0.5, 0.0]), np.array([0.0, 0.5])
        across = self.to_glass(points + right) - self.to_glass(points - right)
        down = self.to_glass(points + below) - self.to_glass(points - below)
        return np.sqrt(np.abs(across[:, 0] * down[:, 1] - across[:, 1] * down[:, 0]))


@dataclass(frozen=True, eq=False)
class Rectification:
    """Pictures seen square to the glass.

    Attributes
    ----------
    resampling : Resampling
        For `ImageSequence.resample`.
    metres_per_pixel : float
        Of the new pictures.
    left, top : float
        (x, z) on the glass of pixel (0, 0) in m.
    """

    resampling: Resampling
    metres_per_pixel: float
    left: float
    top: float


def calibrate_glass(
    pixels: Sequence[Sequence[float]] | np.ndarray,
    world: Sequence[Sequence[float]] | np.ndarray,
    *,
    shape: tuple[int, int],
    lens: Lens | None = None,
) -> GlassCalibration:
    """Find the glass from four or more points on it.

    Parameters
    ----------
    pixels : (N, 2)
        x and y px in the camera's picture, whose pixel centres are whole numbers.
    world : (N, 2)
        x along the bin and z up, in m, of the same points.
    shape : (int, int)
        Rows and columns of the camera's picture.
    lens : Lens, optional
        Of a camera whose pictures have this size.

    Raises
    ------
    CalibrationError
        If there are fewer than four, or (nearly) all but one lie on a line.
    """
    seen, places = _checked(pixels, "pixels"), _checked(world, "world")
    if len(seen) != len(places) or len(seen) < LEAST_POINTS:
        raise CalibrationError(
            f"glass points: {len(seen)} in the picture and {len(places)} on the glass: "
            f"needed are {LEAST_POINTS} or more of each"
        )
    if lens is not None and lens.shape != shape:
        raise CalibrationError(
            f"lens: of pictures of {lens.shape[1]} x {lens.shape[0]} px, "
            f"but these have {shape[1]} x {shape[0]} px"
        )
    straight = seen if lens is None else lens.undistorted(seen)
    homography = _fitted(places, straight)
    off = np.linalg.norm(_projected(homography, places) - straight, axis=1)
    rms = float(np.sqrt(np.mean(off**2)))
    return GlassCalibration(shape, homography, lens, rms, float(off.max()), len(seen))


def _checked(points: Sequence[Sequence[float]] | np.ndarray, name: str) -> np.ndarray:
    array = np.asarray(points, np.float64)
    if array.ndim != 2 or array.shape[1] != 2 or not np.isfinite(array).all():
        raise CalibrationError(f"glass points: {name}: must be pairs of finite numbers")
    return array


def _fitted(places: np.ndarray, pixels: np.ndarray) -> np.ndarray:
    """Homography of least squared distances in the picture (OpenCV's keeps seven digits only)."""
    from scipy.optimize import least_squares

    on_glass, in_picture = _centring(places), _centring(pixels)
    x, u = _projected(on_glass, places), _projected(in_picture, pixels)
    start = _linear_solution(x, u)
    if len(places) > LEAST_POINTS:
        fit = least_squares(lambda h: (_projected(h.reshape(3, 3), x) - u).ravel(), start.ravel(), xtol=1e-14)
        start = fit.x.reshape(3, 3)
    homography = np.linalg.inv(in_picture) @ start @ on_glass
    return np.asarray(homography / homography[2, 2])


def _linear_solution(places: np.ndarray, pixels: np.ndarray) -> np.ndarray:
    """Homography by the direct linear transformation, of points around the origin at a distance near 1.

    Raises
    ------
    CalibrationError
        If the points leave it open: eight equations must tell apart its eight numbers.
    """
    (x, z), (u, v) = places.T, pixels.T
    one, zero = np.ones_like(x), np.zeros_like(x)
    of_u = np.stack([x, z, one, zero, zero, zero, -u * x, -u * z, -u], axis=1)
    of_v = np.stack([zero, zero, zero, x, z, one, -v * x, -v * z, -v], axis=1)
    _, values, vectors = np.linalg.svd(np.concatenate([of_u, of_v]))
    if values[7] < _WEAKEST * values[0]:
        raise CalibrationError("glass points: too many lie on one line: choose four corners of a rectangle")
    return vectors[8].reshape(3, 3)


def _centring(points: np.ndarray) -> np.ndarray:
    """Matrix that moves points (N, 2) to the origin and scales them to a distance near 1."""
    x, y = points.mean(axis=0)
    scale = max(float(np.sqrt(((points - [x, y]) ** 2).mean())), 1e-300)
    return np.array([[1 / scale, 0, -x / scale], [0, 1 / scale, -y / scale], [0, 0, 1]])


def _projected(homography: np.ndarray, points: np.ndarray) -> np.ndarray:
    seen = _homogeneous(np.asarray(points, np.float64)) @ homography.T
    return seen[:, :2] / seen[:, 2:]


def _homogeneous(points: np.ndarray) -> np.ndarray:
    return np.concatenate([points, np.ones((len(points), 1))], axis=1)
