"""Displacement as the 16-bit PNG of the KITTI flow benchmark.

Format (Menze and Geiger, CVPR 2015, the development kit's `readme.txt`): three 16-bit channels; red is
64 u + 32768, green is 64 v + 32768, blue is 1 where flow is known and 0 elsewhere. Values are rounded to the
next 1/64 px, and reach from -512 to just under 512 px.
"""

from pathlib import Path

import numpy as np

from soft.flow.field import FlowError

QUANTUM = 1 / 64
"""px; a value read back is within half of it of the one written."""
_ZERO = 32768
_GREATEST = 65535


def read_kitti(path: str | Path) -> np.ndarray:
    """Displacement (H, W, 2) float32 px; unknown flow is NaN in both components.

    Raises
    ------
    FlowError
        If the file is missing, or no PNG of three 16-bit channels.
    """
    import cv2

    path = Path(path)
    if not path.is_file():
        raise FlowError(f"{path}: no such file")
    picture = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if picture is None or picture.dtype != np.uint16 or picture.ndim != 3 or picture.shape[2] != 3:
        raise FlowError(f"{path}: not a KITTI flow picture: a PNG of three 16-bit channels is needed")
    known, v, u = (picture[:, :, channel] for channel in range(3))  # OpenCV's order is blue, green, red
    flow = (np.stack([u, v], axis=-1).astype(np.float32) - _ZERO) * np.float32(QUANTUM)
    flow[known == 0] = np.nan
    return flow


def write_kitti(path: str | Path, displacement: np.ndarray) -> None:
    """Write displacement (H, W, 2) in px; NaN becomes unknown flow.

    Raises
    ------
    FlowError
        If the shape is another, or a displacement does not fit.
    """
    import cv2

    values = np.asarray(displacement, np.float64)
    if values.ndim != 3 or values.shape[2] != 2:
        raise FlowError(f"displacement: shape {values.shape}: must be (H, W, 2)")
    known = np.asarray(np.isfinite(values).all(axis=2))
    level = np.where(known[:, :, None], np.rint(values / QUANTUM) + _ZERO, 0)
    if level.min(initial=0) < 0 or level.max(initial=0) > _GREATEST:
        furthest = np.abs(values[known]).max()
        raise FlowError(f"{path}: displacement of {furthest:.1f} px: KITTI's 16 bit hold less than 512 px")
    picture = np.dstack([known, level[:, :, 1], level[:, :, 0]]).astype(np.uint16)
    if not cv2.imwrite(str(path), picture):
        raise FlowError(f"{path}: cannot be written")
