"""`estimate_flow`: checks what goes in, lets an estimator work, says where its answer is a measurement."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from soft.flow.consistency import Check, landed, landing, read_back
from soft.flow.estimator import Estimator
from soft.flow.field import FlowError, FlowField, known
from soft.flow.opencv import opencv_threads
from soft.flow.options import require_flag
from soft.flow.plain_uncertainty import plain_uncertainty
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
    forward_backward: bool | float | None = None,
    uncertainty: bool = True,
    **options: object,
) -> FlowField:
    """Displacement of every pixel of `first` to where it is in `second`.

    Parameters
    ----------
    first, second : (H, W) array
        Grey pictures, 0-255, finite. Floating ones keep their fractions as far as the method can use them.
    method : str or callable, optional
        A name of `BUILT_IN` or `VARIANTS`, `package.module:function`, `files:FOLDER` (needs the option
        `pair`), or a function `f(first, second, mask) -> (H, W, 2)`.
    mask : (H, W) bool, optional
        True = use. Pixels outside are not valid. Libraries' methods cannot ignore them otherwise.
    device : str, optional
        Where to compute.
    threads : int, optional
        Threads of OpenCV, for this call only; OpenCV's own setting by default.
    forward_backward : bool or float, optional
        Measure from `second` to `first` too, and take for valid only what comes back to where it started: by
        the rule of Sundaram, Brox and Keutzer (2010) if true, to within so many px if a number. By default
        built-in methods do, users' own do not. Costs about as much again.
    uncertainty : bool, optional
        False leaves it out: no time is spent on an estimate that the method itself does not give.
    **options
        The method's own; unknown ones are refused.

    Returns
    -------
    FlowField
        Displacement in px, x right and y down, forward, on the grid of `first`. Not valid, and NaN: outside
        the mask, where the motion leads out of the picture, where the method gave none, where the way back
        misses the start, and, with the built-in methods, where the first picture has no texture within 7 px.

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
    check = _check(estimator, forward_backward, settings)
    require_flag("uncertainty", uncertainty)
    first, second = _checked_pictures(first, second, estimator)
    usable = _checked_mask(mask, first.shape)
    if not estimator.own_texture:
        usable = usable & has_texture(first)
    with opencv_threads(threads):
        if estimator.start is not None:
            estimator.start(device, threads)
        field = _solve(estimator, first, second, usable, settings)
        right = lands_inside(field.displacement)
        if not estimator.own_texture:
            right &= lands_on(has_texture(second), field.displacement)
        back = None
        if check is not None and (field.valid & right).any():
            back = _way_back(estimator, first, second, field, settings)
            right &= _passed(check, field.displacement, back)
        field = field.where(right, copy=False)  # made here, nobody else has it
        return _with_uncertainty(estimator, first, second, field, back, settings, wanted=uncertainty)


def resolve_options(method: str | Callable, options: Mapping[str, object]) -> dict[str, object]:
    """Every option of `estimate_flow` that changes its answer, spelt out: for the record in a result.

    Raises
    ------
    FlowError
        If an option is unknown or impossible.
    """
    estimator, own = find_estimator(method), dict(options)
    wish, uncertainty = own.pop("forward_backward", None), own.pop("uncertainty", True)
    settings = estimator.options(own)
    check = _check(estimator, wish, settings)  # type: ignore[arg-type]
    require_flag("uncertainty", uncertainty)
    told: bool | float = check is not None
    if check is not None and check.tolerance is not None:
        told = check.tolerance
    return estimator.resolved(settings) | {"forward_backward": told, "uncertainty": uncertainty}


def has_texture(picture: np.ndarray) -> np.ndarray:
    """Tell where grey levels within 7 px differ by more than rounding does.

    (H, W) bool from (H, W) float32 0-255.
    """
    import cv2

    window = np.ones((TEXTURE_WINDOW, TEXTURE_WINDOW), np.uint8)
    whole = picture.astype(np.uint8)
    if np.array_equal(whole, picture):  # several times as fast
        picture = whole
    return cv2.dilate(picture, window) - cv2.erode(picture, window) >= TEXTURE_RANGE


def lands_inside(displacement: np.ndarray) -> np.ndarray:
    """Tell where a displacement (H, W, 2) px ends between the outermost pixel centres; False for NaN."""
    height, width = displacement.shape[:2]
    x, y = landing(displacement)
    return (x >= 0) & (x <= width - 1) & (y >= 0) & (y <= height - 1)


def lands_on(region: np.ndarray, displacement: np.ndarray) -> np.ndarray:
    """Tell where a displacement (H, W, 2) px ends beside a pixel of `region` (H, W) bool; False for NaN."""
    import cv2

    if region.all():
        return known(displacement)
    x, y = landing(displacement)
    share = cv2.remap(region.astype(np.float32), x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return (share > 0) & known(displacement)


def _check(estimator: Estimator, wish: bool | float | None, settings: object) -> Check | None:
    own = estimator.forward_backward
    check = Check.of((own(settings) if callable(own) else own) if wish is None else wish)
    if check is not None and not estimator.reversible:
        raise FlowError(f"forward_backward: {wish!r}: method {estimator.name!r} knows one direction only")
    return check


def _way_back(
    estimator: Estimator, first: np.ndarray, second: np.ndarray, field: FlowField, settings: object
) -> np.ndarray:
    """Backward displacement where pixels land, px; of every second or so each way, where it was told so."""
    backward = _backward(estimator, first, second, field, settings)
    step = -(-first.shape[0] // backward.shape[0])
    if step == 1:
        return read_back(field.displacement, backward)
    return step * read_back(field.displacement[::step, ::step] / step, backward / step)


def _passed(check: Check, forward: np.ndarray, back: np.ndarray) -> np.ndarray:
    height, width = forward.shape[:2]
    step = -(-height // back.shape[0])
    passed = check.passed(forward[::step, ::step], back)
    return passed.repeat(step, axis=0).repeat(step, axis=1)[:height, :width]


def _backward(
    estimator: Estimator, first: np.ndarray, second: np.ndarray, field: FlowField, settings: object
) -> np.ndarray:
    """Displacement from the second picture to the first, px, on the second's grid or a coarser one."""
    if estimator.backward is not None:
        return estimator.backward(first, second, field, settings)
    usable = landed(field.displacement) if estimator.keeps_to_mask else np.ones(first.shape, bool)
    return estimator.solve(second, first, usable, settings).displacement


def _with_uncertainty(
    estimator: Estimator,
    first: np.ndarray,
    second: np.ndarray,
    field: FlowField,
    back: np.ndarray | None,
    settings: object,
    *,
    wanted: bool,
) -> FlowField:
    if not wanted:
        return replace(field, uncertainty=None)
    if estimator.effective_window is None or field.uncertainty is not None:
        return field
    window = estimator.effective_window(settings)
    sigma = plain_uncertainty(first, second, field.displacement, back, window=window)
    return replace(field, uncertainty=sigma)


def _solve(
    estimator: Estimator, first: np.ndarray, second: np.ndarray, usable: np.ndarray, settings: object
) -> FlowField:
    if not usable.any():
        return FlowField(np.full((*first.shape, 2), np.nan, np.float32), usable)
    return estimator.solve(first, second, usable, settings)


def _checked_pictures(
    first: ArrayLike, second: ArrayLike, estimator: Estimator
) -> tuple[np.ndarray, np.ndarray]:
    first, second = _checked_picture(first, "first"), _checked_picture(second, "second")
    if first.shape != second.shape:
        raise FlowError(f"second picture: shape {second.shape}: the first has {first.shape}")
    if min(first.shape) < estimator.least_side:
        raise FlowError(
            f"pictures of {first.shape[1]} x {first.shape[0]} px: method {estimator.name!r} needs at least "
            f"{estimator.least_side} px each way"
        )
    return first, second


def _checked_picture(picture: ArrayLike, name: str) -> np.ndarray:
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


def _checked_mask(mask: ArrayLike | None, shape: tuple[int, ...]) -> np.ndarray:
    if mask is None:
        return np.ones(shape, bool)
    mask = np.asarray(mask)
    if mask.shape != shape or mask.dtype != bool:
        raise FlowError(f"mask: {mask.dtype} of shape {mask.shape}: must be bool of shape {shape}")
    return mask
