"""Boards of squares to photograph: where their corners are, and where they are seen."""

import re
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from soft.calibration.error import CalibrationError

_WRITTEN = "chessboard:9x6:0.025 (inner corners, square in m) or charuco:11x8:0.02:0.015:DICT_5X5_100 "
_WRITTEN += "(squares, square and marker in m, dictionary)"

_LEAST_CORNERS = 6
"""A view with fewer tells less than its pose takes to know."""


class Board(Protocol):
    """A flat board with corners that are known in m and found in px."""

    def find(self, picture: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """Find corners in a picture.

        Parameters
        ----------
        picture : (H, W) float32
            Grey, 0-255.

        Returns
        -------
        (N, 3) float32, (N, 2) float32 or None
            Places on the board in m, and in the picture in px, whose centres are whole numbers; None where
            the board is not seen.
        """
        ...


@dataclass(frozen=True)
class Chessboard:
    """Plain squares; seen only where every inner corner is.

    Attributes
    ----------
    columns, rows : int
        Inner corners each way.
    square : float
        Side of a square in m.
    """

    columns: int
    rows: int
    square: float

    def __post_init__(self) -> None:
        _require_lattice(self.columns, self.rows, least=3)
        _require_length("square", self.square)

    def find(self, picture: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """Find every corner, or none."""
        import cv2

        size = (self.columns, self.rows)
        grey = _eight_bits(picture)
        seen, corners = cv2.findChessboardCornersSB(grey, size)
        if not seen:
            return None
        # What finds the board most surely does not place its corners best.
        reach = _reach(corners.reshape(self.rows, self.columns, 2))
        enough = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-4)
        corners = cv2.cornerSubPix(grey, corners, (reach, reach), (-1, -1), enough)
        row, column = np.divmod(np.arange(self.columns * self.rows), self.columns)
        places = np.stack([column, row, np.zeros_like(row)], axis=1) * self.square
        return places.astype(np.float32), corners.reshape(-1, 2).astype(np.float32)


@dataclass(frozen=True)
class CharucoBoard:
    """Squares with markers in the white ones, so that a part of the board is enough.

    Attributes
    ----------
    columns, rows : int
        Squares each way.
    square, marker : float
        Sides in m.
    dictionary : str
        OpenCV's name of the markers' dictionary, as `DICT_5X5_100`.
    """

    columns: int
    rows: int
    square: float
    marker: float
    dictionary: str

    def __post_init__(self) -> None:
        import cv2

        _require_lattice(self.columns, self.rows, least=3)
        _require_length("square", self.square)
        _require_length("marker", self.marker)
        if self.marker >= self.square:
            raise CalibrationError(f"board marker: {self.marker:g} m: must be smaller than its square")
        if not hasattr(cv2.aruco, self.dictionary) or not self.dictionary.startswith("DICT_"):
            raise CalibrationError(f"board dictionary: {self.dictionary!r}: OpenCV has none of this name")

    def find(self, picture: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """Find corners whose markers are seen."""
        import cv2

        board = self._board()
        corners, numbers, _, _ = cv2.aruco.CharucoDetector(board).detectBoard(_eight_bits(picture))
        if numbers is None or len(numbers) < _LEAST_CORNERS:
            return None
        places = np.asarray(board.getChessboardCorners())[np.ravel(numbers)]
        return places.astype(np.float32), corners.reshape(-1, 2).astype(np.float32)

    def _board(self) -> Any:
        import cv2

        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, self.dictionary))
        return cv2.aruco.CharucoBoard((self.columns, self.rows), self.square, self.marker, dictionary)


def parse_board(text: str) -> Board:
    """Read a board as it is written on the command line.

    >>> parse_board("chessboard:9x6:0.025")
    Chessboard(columns=9, rows=6, square=0.025)

    Raises
    ------
    CalibrationError
        If it is written otherwise, or there is no such board.
    """
    kind, _, rest = text.partition(":")
    parts = rest.split(":")
    size = re.fullmatch(r"(\d+)x(\d+)", parts[0])
    wanted = {"chessboard": 2, "charuco": 4}.get(kind)
    if size is None or len(parts) != wanted:
        raise CalibrationError(f"board {text!r}: allowed are {_WRITTEN}")
    columns, rows = int(size[1]), int(size[2])
    try:
        square, *marker = (float(part) for part in parts[1:3])
    except ValueError:
        raise CalibrationError(f"board {text!r}: lengths must be numbers: {_WRITTEN}") from None
    if kind == "chessboard":
        return Chessboard(columns, rows, square)
    return CharucoBoard(columns, rows, square, marker[0], parts[3])


def _reach(corners: np.ndarray) -> int:
    """Px around a corner that hold it and no other: a fifth of the least distance to the next."""
    gaps = [np.linalg.norm(np.diff(corners, axis=axis), axis=2).min() for axis in (0, 1)]
    return int(np.clip(min(gaps) / 5, 2, 11))


def _eight_bits(picture: np.ndarray) -> np.ndarray:
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)


def _require_lattice(columns: int, rows: int, *, least: int) -> None:
    if columns < least or rows < least:
        raise CalibrationError(f"board {columns}x{rows}: needs at least {least} each way")


def _require_length(name: str, value: float) -> None:
    if not (0 < value < np.inf):
        raise CalibrationError(f"board {name}: {value!r}: must be above 0 m")
