"""SoilFlow: what an analysis yields, as an `xarray.Dataset` and as a netCDF-4 file; one table says it all."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray

SCHEMA_VERSION = 1
ENGINE = "h5netcdf"
REQUIRED_ATTRIBUTES = ("schema_version", "method", "options", "versions")


class SoilFlowError(ValueError):
    """A file or data set that is not a SoilFlow of this schema; the message is one line."""


@dataclass(frozen=True)
class VariableSpec:
    """Dimensions, type and meaning of a variable."""

    dims: tuple[str, ...]
    dtype: str
    units: str
    long_name: str


_PIXEL = ("pair", "y", "x")
_PAIR = ("pair",)

VARIABLES = {
    "u": VariableSpec(_PIXEL, "float32", "px", "horizontal displacement in the camera frame, right positive"),
    "v": VariableSpec(_PIXEL, "float32", "px", "vertical displacement in the camera frame, down positive"),
    "uncertainty_u": VariableSpec(_PIXEL, "float32", "px", "standard uncertainty of u, NaN where not told"),
    "uncertainty_v": VariableSpec(_PIXEL, "float32", "px", "standard uncertainty of v, NaN where not told"),
    "valid": VariableSpec(_PIXEL, "bool", "1", "whether motion could be measured"),
    "soil": VariableSpec(_PIXEL, "bool", "1", "whether the first picture shows soil"),
    "moving": VariableSpec(_PIXEL, "bool", "1", "whether it belongs to the moving soil region"),
    "camera_u": VariableSpec(_PAIR, "float32", "px", "apparent horizontal displacement of resting soil"),
    "camera_v": VariableSpec(_PAIR, "float32", "px", "apparent vertical displacement taken out"),
    "inertial_u": VariableSpec(_PIXEL, "float32", "px", "horizontal displacement in the inertial frame"),
    "inertial_v": VariableSpec(_PIXEL, "float32", "px", "vertical displacement in the inertial frame"),
}
CALIBRATED_VARIABLES = {
    "velocity_x": VariableSpec(_PIXEL, "float32", "m s-1", "horizontal velocity in the inertial frame"),
    "velocity_z": VariableSpec(
        _PIXEL, "float32", "m s-1", "vertical velocity in the inertial frame, up positive"
    ),
}
INTERVAL_VARIABLES = {
    "camera_u_low": VariableSpec(_PAIR, "float32", "px", "lower bound of the 95 % interval of camera_u"),
    "camera_u_high": VariableSpec(_PAIR, "float32", "px", "upper bound of the 95 % interval of camera_u"),
    "camera_v_low": VariableSpec(
        _PAIR, "float32", "px", "lower bound of the 95 % interval of camera_v, NaN where not taken out"
    ),
    "camera_v_high": VariableSpec(
        _PAIR, "float32", "px", "upper bound of the 95 % interval of camera_v, NaN where not taken out"
    ),
}
"""Of every SoilFlow written now; those of former versions have none."""
NODE_VARIABLES = {
    "node_x": VariableSpec(_PIXEL, "float32", "px", "where a grid's vector was measured, NaN without one"),
    "node_y": VariableSpec(_PIXEL, "float32", "px", "where a grid's vector was measured, down positive"),
}
"""Of methods that tell of the nodes of a grid only."""
COORDINATES = {
    "first_frame": VariableSpec(_PAIR, "int64", "1", "index of the first frame of the pair"),
    "second_frame": VariableSpec(_PAIR, "int64", "1", "index of the second frame of the pair"),
    "time": VariableSpec(_PAIR, "float64", "s", "time of the first frame"),
}
UNTIMED = VariableSpec(_PAIR, "float64", "frame", "index of the first frame, as the frame rate is unknown")


def variables_for(*, calibrated: bool, gridded: bool, bounded: bool = True) -> dict[str, VariableSpec]:
    """Name the variables of a SoilFlow; `bounded` ones have intervals of the camera's motion."""
    groups = ((calibrated, CALIBRATED_VARIABLES), (gridded, NODE_VARIABLES), (bounded, INTERVAL_VARIABLES))
    return VARIABLES | {name: spec for held, group in groups if held for name, spec in group.items()}


def coordinates_for(*, timed: bool) -> dict[str, VariableSpec]:
    """Name the coordinates of a SoilFlow; without a frame rate, time is told in frames."""
    return dict(COORDINATES) if timed else COORDINATES | {"time": UNTIMED}


def check_soil_flow(
    flow: "xarray.Dataset", *, name: str = "SoilFlow", values: bool = False
) -> "xarray.Dataset":
    """Return `flow` if it has the form of a SoilFlow of this schema; pixels are looked at if asked for.

    Parameters
    ----------
    flow : xarray.Dataset
        What is said to be one.
    name : str, optional
        What to call it in an error message.
    values : bool, optional
        Whether to read every pixel, and see that the values agree: numbers where valid and only there, moving
        within soil, frames in order, and inertial motion and velocity as camera motion and scale have it.

    Raises
    ------
    SoilFlowError
        If the schema version is another, or a dimension, variable, type, unit or attribute is missing or
        wrong; or, if asked for, the first value that contradicts another.
    """
    _check_attributes(flow, name)
    calibrated, gridded, bounded = (
        any(variable in flow.data_vars for variable in group)
        for group in (CALIBRATED_VARIABLES, NODE_VARIABLES, INTERVAL_VARIABLES)
    )
    held = variables_for(calibrated=calibrated, gridded=gridded, bounded=bounded)
    for variable, spec in held.items():
        _check_variable(flow, variable, spec, name)
    timed = "time" not in flow.coords or flow["time"].attrs.get("units") != UNTIMED.units
    for coordinate, spec in coordinates_for(timed=timed).items():
        _check_variable(flow, coordinate, spec, name)
    if values:
        from soft.soilflow_values import wrong_values

        for wrong in wrong_values(flow):
            raise SoilFlowError(f"{name}: {wrong}")
    return flow


def read_soil_flow(path: str | Path) -> "xarray.Dataset":
    """Open a SoilFlow file; pixels are read when they are used.

    The file stays open until the data set is closed (it is a context manager).

    Raises
    ------
    SoilFlowError
        If the file is missing, no netCDF-4 file, or no SoilFlow of this schema.
    """
    import xarray

    path = Path(path)
    if not path.is_file():
        raise SoilFlowError(f"{path}: no such file")
    try:
        # Not kept in memory, as a sequence may be larger; nor is a unit of time turned into a date.
        flow = xarray.open_dataset(path, engine=ENGINE, cache=False, decode_times=False)
    except Exception as error:  # xarray raises whatever the damage leads to
        raise SoilFlowError(f"{path}: not a readable netCDF-4 file") from error
    try:
        flow = flow.set_coords([name for name in COORDINATES if name in flow])
        return check_soil_flow(flow, name=str(path))
    except SoilFlowError:
        flow.close()
        raise


def _check_attributes(flow: "xarray.Dataset", name: str) -> None:
    version = flow.attrs.get("schema_version")
    if version is None:
        raise SoilFlowError(f"{name}: no schema_version: not a SoilFlow")
    if version != SCHEMA_VERSION:
        raise SoilFlowError(f"{name}: schema_version {version}: this reads {SCHEMA_VERSION}")
    for attribute in REQUIRED_ATTRIBUTES:
        if attribute not in flow.attrs:
            raise SoilFlowError(f"{name}: attribute {attribute} is missing")


def _check_variable(flow: "xarray.Dataset", variable: str, spec: VariableSpec, name: str) -> None:
    if variable not in flow.variables:
        raise SoilFlowError(f"{name}: variable {variable} is missing")
    found = flow[variable]
    for what, has, must in (
        ("dimensions", found.dims, spec.dims),
        ("type", found.dtype, np.dtype(spec.dtype)),
        ("units", found.attrs.get("units"), spec.units),
    ):
        if has != must:
            raise SoilFlowError(f"{name}: variable {variable}: {what} {has}: must be {must}")
    if not found.attrs.get("long_name"):
        raise SoilFlowError(f"{name}: variable {variable}: long_name is missing")
