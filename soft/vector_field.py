"""Soil flow in the form that PIV programs take: a grid of vectors over x, y and time."""

from typing import TYPE_CHECKING

import numpy as np

from soft.velocity import to_velocity

if TYPE_CHECKING:
    import xarray


def vector_field(flow: "xarray.Dataset", *, stride: int = 16) -> "xarray.Dataset":
    """Every n-th vector of a SoilFlow, as pivpy and its like have it.

    Vectors are samples: nothing is averaged or filled. Outside soil and where motion was not measured, `u`
    and `v` are NaN and `chc` is 0.

    Parameters
    ----------
    flow : xarray.Dataset
        A SoilFlow.
    stride : int, optional
        Every how many px each way.

    Returns
    -------
    xarray.Dataset
        Over `y, x, t`: `u` (right) and `v` (**up**) in the inertial frame, m/s where the flow is calibrated
        and px a pair otherwise; `chc`, 1 where measured. `x` and `y` in m or px from the centre of the lowest
        pixel to the left, y up, so that curl and divergence have the usual signs; `t` in s or frames.
    """
    import xarray

    calibrated = "velocity_x" in flow
    every = slice(stride // 2, None, stride)
    part = flow.isel(y=every, x=every).transpose("y", "x", "pair")
    told = (part["valid"] & part["soil"]).to_numpy()
    if calibrated:
        right, up = part["velocity_x"].to_numpy(), part["velocity_z"].to_numpy()
    else:
        pixels = np.stack([part["inertial_u"].to_numpy(), part["inertial_v"].to_numpy()], axis=-1)
        right, up = to_velocity(pixels, metres_per_pixel=1.0, time_step=1.0)
    scale = flow.attrs["metres_per_pixel"] if calibrated else 1.0
    columns, rows = (np.arange(flow.sizes[axis])[every] for axis in ("x", "y"))
    length, speed = ("m", "m/s") if calibrated else ("px", "px/frame")
    dims = ("y", "x", "t")
    field = xarray.Dataset(
        {
            "u": (
                dims,
                np.where(told, right, np.nan),
                {"units": speed, "long_name": "velocity to the right"},
            ),
            "v": (dims, np.where(told, up, np.nan), {"units": speed, "long_name": "velocity up"}),
            "chc": (dims, told.astype(np.float64), {"units": "1", "long_name": "1 where measured"}),
        },
        coords={
            "x": ("x", columns * scale, {"units": length}),
            "y": ("y", (flow.sizes["y"] - 1 - rows) * scale, {"units": length}),
            "t": ("t", flow["time"].to_numpy(), {"units": flow["time"].attrs.get("units", "frame")}),
        },
    )
    return field.isel(y=slice(None, None, -1))  # lowest row first: coordinates that grow
