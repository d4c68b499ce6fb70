"""What a lens does to a picture: the pinhole camera with radial and tangential distortion (Brown, 1966)."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from soft.calibration.board import Board
from soft.calibration.error import CalibrationError
from soft.sequence.resampling import Resampling
from soft.toml_file import read_toml

SCHEMA_VERSION = 1
LEAST_VIEWS = 3
_ROWS_AT_A_TIME = 128


@dataclass(frozen=True, eq=False)
class Lens:
    """A calibrated camera; pixel centres are whole numbers.

    Attributes
    ----------
    shape : (int, int)
        Rows and columns of its pictures.
    camera_matrix : (3, 3) float64
        Focal lengths and principal point in px.
    distortion : (5,) float64
        OpenCV's k1, k2, p1, p2, k3.
    reprojection_error : float
        Root mean square distance of corners seen from corners expected, px.
    views : tuple of str
        The pictures it was found from.
    """

    shape: tuple[int, int]
    camera_matrix: np.ndarray
    distortion: np.ndarray
    reprojection_error: float = float("nan")
    views: tuple[str, ...] = ()

    def undistorted(self, points: np.ndarray) -> np.ndarray:
        """Where points (N, 2) px of the picture would be seen without distortion, (N, 2) px."""
        import cv2

        points = np.asarray(points, np.float64).reshape(-1, 1, 2)
        precise = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-10)
        matrix = self.camera_matrix
        return cv2.undistortPoints(points, matrix, self.distortion, P=matrix, criteria=precise).reshape(-1, 2)

    def distorted(self, points: np.ndarray) -> np.ndarray:
        """Where points (N, 2) px without distortion are seen in the picture, (N, 2) px."""
        import cv2

        homogeneous = np.concatenate([np.asarray(points, np.float64), np.ones((len(points), 1))], axis=1)
        rays = homogeneous @ np.linalg.inv(self.camera_matrix).T
        still = np.zeros(3)
        seen, _ = cv2.projectPoints(rays.reshape(-1, 1, 3), still, still, self.camera_matrix, self.distortion)
        return seen.reshape(-1, 2)

    def undistortion(self) -> Resampling:
        """Pictures without distortion, of the same size and, at the principal point, the same scale."""
        height, width = self.shape
        return Resampling(mapped_grid((height, width), self.distorted), self.shape)

    def write(self, path: str | Path) -> None:
        """Write a TOML file.

        Raises
        ------
        CalibrationError
            There is a file of this name.
        """
        import tomli_w

        content = {
            "schema_version": SCHEMA_VERSION,
            "width": self.shape[1],
            "height": self.shape[0],
            "camera_matrix": self.camera_matrix.tolist(),
            "distortion": self.distortion.tolist(),
            "reprojection_error": self.reprojection_error,
            "views": list(self.views),
        }
        try:
            with Path(path).open("x", encoding="utf-8") as file:
                file.write("# A camera's lens: px, pixel centres at whole numbers; k1, k2, p1, p2, k3.\n")
                file.write(tomli_w.dumps(content))
        except FileExistsError:
            raise CalibrationError(f"{path}: exists already: nothing is overwritten") from None

    @classmethod
    def read(cls, path: str | Path) -> "Lens":
        """Read what `write` wrote.

        Raises
        ------
        CalibrationError
            If the file is missing, or no lens of this schema.
        """
        try:
            table = read_toml(Path(path))
            return cls._from(table)
        except FileNotFoundError:
            raise CalibrationError(f"lens {path}: no such file") from None
        except KeyError as error:
            raise CalibrationError(f"lens {path}: not a lens of this program: {error} is missing") from None
        except (TypeError, ValueError) as error:
            raise CalibrationError(f"lens {path}: not a lens of this program: {error}") from error

    @classmethod
    def _from(cls, table: dict[str, Any]) -> "Lens":
        if table["schema_version"] != SCHEMA_VERSION:
            raise CalibrationError(f"schema_version {table['schema_version']!r}: this reads {SCHEMA_VERSION}")
        matrix = np.array(table["camera_matrix"], np.float64).reshape(3, 3)
        distortion = np.array(table["distortion"], np.float64).reshape(5)
        if not (np.isfinite(matrix).all() and np.isfinite(distortion).all() and matrix[0, 0] > 0):
            raise CalibrationError("camera_matrix and distortion must be finite, focal lengths above 0")
        shape = int(table["height"]), int(table["width"])
        return cls(shape, matrix, distortion, float(table["reprojection_error"]), tuple(table["views"]))


def calibrate_lens(
    pictures: Iterable[tuple[str, np.ndarray]], board: Board, *, radial_terms: int = 2
) -> Lens:
    """Find a camera's lens from photographs of a board, held in many ways (Zhang, 2000; OpenCV).

    Parameters
    ----------
    pictures : iterable of (str, (H, W) float32 array)
        Name and grey levels, all of one size; those in which the board is not seen are left out. Taken with
        the focus and aperture of the experiment, the board tilted up to 45 degrees each way and, over all of
        them, in every part of the picture.
    board : Board
    radial_terms : int, optional
        2: k1 and k2; 3: k3, too, which only wide-angle lenses need and few pictures cannot tell.

    Raises
    ------
    CalibrationError
        If the board is seen in fewer than three, or they tell no lens.
    """
    if radial_terms not in (2, 3):
        raise CalibrationError(f"radial_terms: {radial_terms!r}: allowed are 2 and 3")
    names, places, corners, shape, count = _views(pictures, board)
    if len(names) < LEAST_VIEWS or shape is None:
        raise CalibrationError(
            f"the board is seen in {len(names)} of {count} pictures: at least {LEAST_VIEWS} are needed"
        )
    return _fitted(names, places, corners, shape, radial_terms)


def mapped_grid(shape: tuple[int, int], mapping: Any) -> np.ndarray:
    """Apply a mapping of points (N, 2) to every pixel of a grid, (H, W, 2) float32, some rows at a time."""
    height, width = shape
    source = np.empty((height, width, 2), np.float32)
    for top in range(0, height, _ROWS_AT_A_TIME):
        y, x = np.mgrid[top : min(top + _ROWS_AT_A_TIME, height), :width].astype(np.float64)
        source[top : top + len(y)] = mapping(np.stack([x.ravel(), y.ravel()], axis=1)).reshape(*y.shape, 2)
    return source


def _views(
    pictures: Iterable[tuple[str, np.ndarray]], board: Board
) -> tuple[list[str], list[np.ndarray], list[np.ndarray], tuple[int, int] | None, int]:
    names, places, corners = [], [], []
    shape: tuple[int, int] | None = None
    count = 0
    for name, picture in pictures:
        count += 1
        if shape is not None and picture.shape != shape:
            raise CalibrationError(
                f"{name}: {picture.shape[1]} x {picture.shape[0]} px, but the first picture has "
                f"{shape[1]} x {shape[0]} px: all must be of one camera, the same way up"
            )
        shape = picture.shape[0], picture.shape[1]
        found = board.find(picture)
        if found is not None:
            names.append(name)
            places.append(found[0])
            corners.append(found[1])
    return names, places, corners, shape, count


def _fitted(
    names: list[str],
    places: list[np.ndarray],
    corners: list[np.ndarray],
    shape: tuple[int, int],
    radial_terms: int,
) -> Lens:
    import cv2

    flags = cv2.CALIB_FIX_K3 if radial_terms == 2 else 0
    size = shape[1], shape[0]
    try:
        error, matrix, distortion, _, _ = cv2.calibrateCamera(places, corners, size, None, None, flags=flags)
    except cv2.error as fault:
        raise CalibrationError(f"the pictures tell no lens: {fault.err or fault}") from fault
    values = np.ravel(distortion)[:5]
    if not (np.isfinite(matrix).all() and np.isfinite(values).all()):
        raise CalibrationError("the pictures tell no lens: tilt the board each way, and fill the picture")
    return Lens(shape, matrix, values, float(error), tuple(names))
