"""`estimate_flow`: checks what goes in, lets an estimator work, says where its answer is a measurement."""

from collections.abc import Callable

import numpy as np

from soft.flow.estimator import Estimator
from soft.flow.field import FlowError, FlowField
from soft.flow.opencv import opencv_threads
from soft.flow.registry import find_estimator

DEFAULT = "robust-affine"

# A pixel has texture if grey levels within this window differ by at least this much. One level of 255 is what
# rounding alone makes of a smooth surface.
TEXTURE_WINDOW = 15
TEXTURE_RANGE = 1.5


def estimate_flow(
    first: np.ndarray,
    second: np.ndarray,
    *,
    method: str | Callable = DEFAULT,
    mask: np.ndarray | None = None,
    device: str = "cpu",
    threads: int | None = None,
    **options: object,
) -> FlowField:
    """Displacement of every pixel of `first` to where it is in `second`.

    Parameters
    ----------
    first, second : (H, W) array
        Grey pictures, 0-255, finite. Floating ones keep their fractions as far as the method can use them.
    method : str or callable, optional
        `dis`, `farneback`, `package.module:function`, `files:FOLDER` (needs the option `pair`), or a function
        `f(first, second, mask) -> (H, W, 2)`.
    mask : (H, W) bool, optional
        True = use. Pixels outside are not valid. Neither DIS nor Farnebäck can ignore them otherwise.
    device : str, optional
        Where to compute.
    threads : int, optional
        Threads of OpenCV, for this call only; OpenCV's own setting by default.
    **options
        The method's own; unknown ones are refused.

    Returns
    -------
    FlowField
        Displacement in px, x right and y down, forward, on the grid of `first`. Not valid, and NaN: outside
        the mask, where the motion leads out of the picture, where the method gave none, and, with the
        built-in methods, where the first picture has no texture within 7 px.

    Raises
    ------
    FlowError
        If pictures, mask, method, options, device or threads are not usable.
    """
    estimator = find_estimator(method)
    if device not in estimator.devices:
        raise FlowError(
            f"device {device!r}: method {estimator.name!r} runs on {', '.join(estimator.devices)}"
        )
    settings = estimator.options(options)
    first, second = _checked_pictures(first, second, estimator)
    usable = _checked_mask(mask, first.shape)
    if not estimator.own_texture:
        usable = usable & has_texture(first)
    with opencv_threads(threads):
        if estimator.start is not None:
            estimator.start(device, threads)
        field = _solve(estimator, first, second, usable, settings)
    return field.where(lands_inside(field.displacement))


def has_texture(picture: np.ndarray) -> np.ndarray:
    """Tell where grey levels within 7 px differ by more than rounding does.

    (H, W) bool from (H, W) float32 0-255.
    """
    import cv2

    window = np.ones((TEXTURE_WINDOW, TEXTURE_WINDOW), np.uint8)
    return cv2.dilate(picture, window) - cv2.erode(picture, window) >= TEXTURE_RANGE


def lands_inside(displacement: np.ndarray) -> np.ndarray:
    """Tell where a displacement (H, W, 2) px ends between the outermost pixel centres; False for NaN."""
    height, width = displacement.shape[:2]
    x = np.arange(width, dtype=np.float32) + displacement[:, :, 0]
    y = np.arange(height, dtype=np.float32)[:, None] + displacement[:, :, 1]
    return (x >= 0) & (x <= width - 1) & (y >= 0) & (y <= height - 1)


def _solve(estimator: Estimator, first, second, usable, settings) -> FlowField:
    if not usable.any():
        return FlowField(np.full((*first.shape, 2), np.nan, np.float32), usable)
    return estimator.solve(first, second, usable, settings)


def _checked_pictures(first, second, estimator: Estimator) -> tuple[np.ndarray, np.ndarray]:
    first, second = (_checked_picture(p, n) for p, n in ((first, "first"), (second, "second")))
    if first.shape != second.shape:
        raise FlowError(f"second picture: shape {second.shape}: the first has {first.shape}")
    if min(first.shape) < estimator.least_side:
        raise FlowError(
            f"pictures of {first.shape[1]} x {first.shape[0]} px: method {estimator.name!r} needs at least "
            f"{estimator.least_side} px each way"
        )
    return first, second


def _checked_picture(picture, name: str) -> np.ndarray:
    picture = np.asarray(picture)
    if picture.ndim != 2 or picture.size == 0:
        raise FlowError(f"{name} picture: shape {picture.shape}: must be grey, (H, W)")
    if picture.dtype.kind not in "fiu":
        raise FlowError(f"{name} picture: type {picture.dtype}: must be real numbers")
    picture = np.ascontiguousarray(picture, dtype=np.float32)
    low, high = float(picture.min()), float(picture.max())
    if not np.isfinite(low + high):
        count = int((~np.isfinite(picture)).sum())
        raise FlowError(f"{name} picture: {count} values are not finite: all must be numbers in 0-255")
    if low < 0 or high > 255:
        raise FlowError(f"{name} picture: grey levels {low:g} to {high:g}: must lie in 0-255")
    return picture


def _checked_mask(mask, shape: tuple[int, ...]) -> np.ndarray:
    if mask is None:
        return np.ones(shape, bool)
    mask = np.asarray(mask)
    if mask.shape != shape or mask.dtype != bool:
        raise FlowError(f"mask: {mask.dtype} of shape {mask.shape}: must be bool of shape {shape}")
    return mask
