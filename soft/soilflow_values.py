"""Whether the values of a SoilFlow agree with each other, pair by pair."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray

# float32 holds seven digits; two roundings may part what is equal.
_RELATIVE = 4e-7
_PIXEL_VARIABLES = (
    "u", "v", "inertial_u", "inertial_v", "uncertainty_u", "uncertainty_v", "valid", "soil", "moving",
)  # fmt: skip
_OPTIONAL = ("velocity_x", "velocity_z", "node_x", "node_y")


def wrong_values(flow: "xarray.Dataset") -> Iterator[str]:
    """Say, a line each, where values contradict each other; memory holds one pair.

    Parameters
    ----------
    flow : xarray.Dataset
        Has the form of a SoilFlow.
    """
    yield from _wrong_sizes(flow)
    yield from _wrong_times(flow)
    names = [*_PIXEL_VARIABLES, *(name for name in _OPTIONAL if name in flow)]
    for pair in range(flow.sizes["pair"]):
        part = flow[[*names, "camera_u", "camera_v"]].isel(pair=pair).load()
        arrays = {name: part[name].to_numpy() for name in (*names, "camera_u", "camera_v")}
        scale = _velocity_scale(flow, pair)
        for wrong in _wrong_pixels(arrays, scale):
            yield f"pair {pair}: {wrong}"


def _wrong_sizes(flow: "xarray.Dataset") -> Iterator[str]:
    for dim in ("pair", "y", "x"):
        if flow.sizes[dim] < 1:
            yield f"dimension {dim}: {flow.sizes[dim]}: must be at least 1"
    for name in ("metres_per_pixel", "frame_rate"):
        value = flow.attrs.get(name)
        if value is None and "velocity_x" in flow:
            yield f"attribute {name} is missing, but there are velocities"
        elif value is not None and not (np.isfinite(value) and value > 0):
            yield f"attribute {name}: {value}: must be above 0"


def _wrong_times(flow: "xarray.Dataset") -> Iterator[str]:
    first, second, time = (flow[name].to_numpy() for name in ("first_frame", "second_frame", "time"))
    if (first < 0).any():
        yield f"first_frame: {first.min()}: must be at least 0"
    if (second <= first).any():
        pair = int(np.argmax(second <= first))
        yield f"pair {pair}: second_frame {second[pair]}: must be after first_frame {first[pair]}"
    if not np.isfinite(time).all():
        yield "time: not a number"


def _velocity_scale(flow: "xarray.Dataset", pair: int) -> float | None:
    """M/s per px of displacement of a pair."""
    if "velocity_x" not in flow or not {"metres_per_pixel", "frame_rate"} <= flow.attrs.keys():
        return None
    step = int(flow["second_frame"][pair]) - int(flow["first_frame"][pair])
    return float(flow.attrs["metres_per_pixel"]) * float(flow.attrs["frame_rate"]) / max(step, 1)


def _wrong_pixels(arrays: dict[str, np.ndarray], scale: float | None) -> Iterator[str]:
    """What is wrong in one pair."""
    valid = arrays["valid"]
    for name in ("u", "v", "inertial_u", "inertial_v"):
        known = np.isfinite(arrays[name])
        yield from _where(known & ~valid, f"{name} is told where not valid")
        yield from _where(valid & ~known, f"valid, but {name} is not a number")
    yield from _where(arrays["moving"] & ~arrays["soil"], "moving, but not soil")
    for name in ("uncertainty_u", "uncertainty_v"):
        told = ~np.isnan(arrays[name])
        yield from _where(told & ~valid, f"{name} is told where not valid")
        yield from _where(told & ~(arrays[name] >= 0), f"{name} is below 0")
    for axis in ("u", "v"):
        expected = arrays[axis] - arrays[f"camera_{axis}"]
        wrong = _differ(arrays[f"inertial_{axis}"], expected, np.abs(arrays[axis]))
        yield from _where(wrong, f"inertial_{axis} is not {axis} - camera_{axis}")
    if scale is not None:
        for name, axis, sign in (("velocity_x", "u", 1.0), ("velocity_z", "v", -1.0)):
            expected = sign * scale * arrays[f"inertial_{axis}"].astype(np.float64)
            wrong = _differ(arrays[name], expected, np.abs(expected))
            yield from _where(wrong, f"{name} is not inertial_{axis} in m/s")
    if "node_x" in arrays:
        nodes = np.isfinite(arrays["node_x"]) & np.isfinite(arrays["node_y"])
        yield from _where(valid & ~nodes, "valid, but without a node")


def _differ(values: np.ndarray, expected: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Where numbers are further apart than rounding explains; what is NaN is judged elsewhere."""
    known = np.isfinite(values) & np.isfinite(expected)
    with np.errstate(invalid="ignore"):
        room = _RELATIVE * (np.abs(expected) + size) + np.finfo(np.float32).tiny
        return known & (np.abs(values - expected) > room)


def _where(wrong: np.ndarray, what: str) -> Iterator[str]:
    count = int(np.count_nonzero(wrong))
    if count:
        row, column = np.unravel_index(int(np.argmax(wrong)), wrong.shape)
        yield f"{what}: {count} px, the first at x {column}, y {row}"
