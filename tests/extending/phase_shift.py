"""One displacement for the whole picture: the peak of the phase correlation, as OpenCV has it."""

from dataclasses import dataclass

import numpy as np

from soft.flow.estimator import Estimator
from soft.flow.field import FlowField
from soft.flow.options import require_flag


@dataclass(frozen=True)
class PhaseShiftOptions:
    """`window`: fade pictures out towards their borders, where soil comes and goes."""

    window: bool = True

    def __post_init__(self) -> None:
        require_flag("window", self.window)


def _solve(first: np.ndarray, second: np.ndarray, mask: np.ndarray, options: PhaseShiftOptions) -> FlowField:
    import cv2

    faded = cv2.createHanningWindow(first.shape[::-1], cv2.CV_32F) if options.window else None
    shift, _ = cv2.phaseCorrelate(first, second, faded)
    return FlowField(np.broadcast_to(np.float32(shift), (*first.shape, 2)), mask)


ESTIMATOR = Estimator("phase-shift", PhaseShiftOptions, _solve, least_side=16)
