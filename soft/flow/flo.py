"""Middlebury `.flo` files: the one place that reads and writes them.

Layout (Baker et al. 2011, the set's `README.txt`): the float 202021.25 ("PIEH" in ASCII), width and height as
int32, then rows of interleaved u, v as float32, all little-endian. A component above 1e9 in magnitude means
unknown.
"""

from pathlib import Path

import numpy as np

from soft.flow.field import FlowError

TAG = np.float32(202021.25)
UNKNOWN_ABOVE = 1e9
UNKNOWN = np.float32(1.666666752e9)
HEADER_BYTES = 12


def read_flo(path: str | Path) -> np.ndarray:
    """Displacement (H, W, 2) float32 px; unknown flow is NaN in both components.

    Raises
    ------
    FlowError
        If the file is missing, no `.flo` file, or not as long as its header says.
    """
    path = Path(path)
    try:
        content = path.read_bytes()
    except OSError as error:
        raise FlowError(f"{path}: cannot be read: {error.strerror}") from error
    if len(content) < HEADER_BYTES or np.frombuffer(content, "<f4", 1)[0] != TAG:
        raise FlowError(f"{path}: not a Middlebury .flo file")
    width, height = (int(n) for n in np.frombuffer(content, "<i4", 2, offset=4))
    expected = HEADER_BYTES + 8 * width * height
    if width < 1 or height < 1 or len(content) != expected:
        raise FlowError(f"{path}: {len(content)} bytes: {width} x {height} px need {expected}")
    flow = np.frombuffer(content, "<f4", offset=HEADER_BYTES).reshape(height, width, 2).astype(np.float32)
    # Written so that a NaN in the file counts as unknown too.
    flow[~(np.abs(flow) <= UNKNOWN_ABOVE).all(axis=2)] = np.nan
    return flow


def write_flo(path: str | Path, displacement: np.ndarray) -> None:
    """Write displacement (H, W, 2) in px; NaN becomes unknown flow.

    Raises
    ------
    FlowError
        If the shape is another.
    """
    values = np.array(displacement, dtype="<f4")
    if values.ndim != 3 or values.shape[2] != 2:
        raise FlowError(f"displacement: shape {values.shape}: must be (H, W, 2)")
    values[~np.isfinite(values).all(axis=2)] = UNKNOWN
    size = np.array([values.shape[1], values.shape[0]], dtype="<i4")
    Path(path).write_bytes(TAG.astype("<f4").tobytes() + size.tobytes() + values.tobytes())
