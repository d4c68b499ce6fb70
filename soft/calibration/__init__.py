"""From pictures to the glass: pixel size, the camera's tilt, and its lens."""

from soft.calibration.board import Board, CharucoBoard, Chessboard, parse_board
from soft.calibration.error import CalibrationError
from soft.calibration.glass import GlassCalibration, calibrate_glass
from soft.calibration.lens import Lens, calibrate_lens
from soft.calibration.scale import metres_per_pixel_between

__all__ = [
    "Board",
    "CalibrationError",
    "CharucoBoard",
    "Chessboard",
    "GlassCalibration",
    "Lens",
    "calibrate_glass",
    "calibrate_lens",
    "metres_per_pixel_between",
    "parse_board",
]
