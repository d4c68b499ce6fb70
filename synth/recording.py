"""What the simulator leaves behind: states at frame times, and forces finer in time."""

import contextlib
import csv
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from synth.disk import require_space

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

    from synth.implements import Shape

SCHEMA_VERSION = 1

# name: (dimensions, unit, meaning)
VARIABLES = {
    "time": (("frame",), "s", "time in the laboratory, 0 at the first frame"),
    "carriage_x": (
        ("frame",),
        "m",
        "position of the carriage along the bin; a travelling camera moves with it",
    ),
    "implement_x": (("frame",), "m", "position of the implement's reference point (a wheel's axle)"),
    "implement_z": (("frame",), "m", "height of the implement's reference point"),
    "implement_angle": (
        ("frame",),
        "rad",
        "rotation of the implement since touch-down, counter-clockwise positive",
    ),
    "radius": (("particle",), "m", "radius of the particle"),
    "position_x": (("frame", "particle"), "m", "position of the particle's centre along the bin"),
    "position_z": (("frame", "particle"), "m", "height of the particle's centre"),
    "angle": (
        ("frame", "particle"),
        "rad",
        "rotation of the particle since settling, counter-clockwise positive",
    ),
    "velocity_x": (
        ("frame", "particle"),
        "m s-1",
        "velocity of the particle along the bin, in laboratory time",
    ),
    "velocity_z": (("frame", "particle"), "m s-1", "upward velocity of the particle, in laboratory time"),
    "sample_time": (("sample",), "s", "end of the interval a force is averaged over; 0 at the first frame"),
    "travel": (("sample",), "m", "carriage travel since touch-down"),
    "slip": (
        ("sample",),
        "1",
        "of a wheel: 1 - carriage speed / rim speed; for r omega < v: r omega / v - 1",
    ),
    "sinkage": (("sample",), "m", "depth of the implement's lowest point below the levelled surface"),
    "force_x": (
        ("sample",),
        "N",
        "force of the soil on the implement along travel: positive pulls (drawbar)",
    ),
    "force_z": (("sample",), "N", "upward force of the soil on the implement"),
    "torque": (
        ("sample",),
        "N m",
        "moment of the soil about the axle, counter-clockwise positive: resists driving",
    ),
}
# Of a wheel with an elastic rim.
RIM_VARIABLES = {
    "rim_x": (("frame", "node"), "m", "position along the bin of a point of the rim's middle line"),
    "rim_z": (("frame", "node"), "m", "height of the point"),
    "deflection": (
        ("sample",),
        "m",
        "how much nearer the axle is to the rim's lowest point than the unloaded radius",
    ),
    "contact_length": (
        ("sample",),
        "m",
        "horizontal extent of the contacts that carry the middle 95 % of the upward force",
    ),
    "rolling_radius": (
        ("sample",),
        "m",
        "mean speed of the rim over the contact, as seen from the axle, / angular velocity",
    ),
}
# Where a scene asks for them (`timing.record_contacts`): a ragged array, frame after frame.
CONTACT_VARIABLES = {
    "contact_count": (("frame",), "1", "number of the frame's contacts between particles"),
    "contact_first": (("contact",), "1", "index of the contact's first particle"),
    "contact_second": (("contact",), "1", "index of its second particle, greater than that of the first"),
    "contact_normal_force": (
        ("contact",),
        "N m-1",
        "with which the two push each other apart, per metre of width",
    ),
    "contact_tangential_force": (
        ("contact",),
        "N m-1",
        "on the first particle, along the line from first to second turned counter-clockwise by a quarter; "
        "per metre of width",
    ),
}
# Of spheres in a slab; the camera looks along y, through the glass at y = 0.
SLAB_VARIABLES = {
    "position_y": (("frame", "particle"), "m", "distance of the particle's centre from the glass"),
    "velocity_y": (
        ("frame", "particle"),
        "m s-1",
        "velocity of the particle away from the glass, in laboratory time",
    ),
}
AT_GLASS = 0.25
"""Gap to the glass / mean particle diameter up to which, on average, the camera sees a particle."""
FORCE_COLUMNS = {
    "time": "sample_time",
    "travel": "travel",
    "slip": "slip",
    "sinkage": "sinkage",
    "force_x": "force_x",
    "force_z": "force_z",
    "torque": "torque",
}
RIM_COLUMNS = ("deflection", "contact_length", "rolling_radius")
"""Columns of `forces.csv` after those, where there is an elastic rim."""


@contextlib.contextmanager
def _opened(path: str | Path) -> Iterator["xr.Dataset"]:
    """A recording's file, unread; nothing that was read is kept."""
    import xarray as xr

    try:
        data = xr.open_dataset(path, engine="h5netcdf", cache=False)
    except FileNotFoundError:
        raise
    except Exception as error:  # xarray raises whatever the damage leads to
        raise ValueError(f"{path}: not a recording: {error}") from None
    with data:
        if data.attrs.get("schema_version") != SCHEMA_VERSION:
            version = data.attrs.get("schema_version")
            raise ValueError(f"{path}: schema_version = {version!r}: this program reads {SCHEMA_VERSION}")
        yield data


@dataclass(frozen=True)
class Recording:
    """States of particles and implement at frame times, and the implement's forces.

    World frame: x along the bin, z up, z = 0 at the bin's floor; a plate is seen from above in the same
    frame.

    Attributes
    ----------
    data : xarray.Dataset
        The variables of `VARIABLES`, over `frame`, `particle` and `sample`; and, or not, those of
        `CONTACT_VARIABLES`, over `frame` and `contact`, of
        `SLAB_VARIABLES`, and of `RIM_VARIABLES`, over `frame` and `node`, and `sample`. Attributes:
        `schema_version`, `simulation_hash`, `surface_height` (m), `solid_fraction`, and what the simulator
        reports of its own soundness (`synth.dem.soundness`): `inertial_number_median`,
        `inertial_number_p95`, and the same of soil that carries the load, `inertial_number_carrying_median`,
        `inertial_number_carrying_p95`; `mean_pressure` (Pa, under the implement), `stiffness_ratio` (contact
        stiffness / mean pressure), `overlap_mean`, `overlap_p99`, `overlap_max` (/ mean diameter of the two),
        `steps_per_contact`. One that had to stop has
        `stopped`, the reason, instead.
    """

    data: "xr.Dataset"

    @classmethod
    def from_arrays(cls, arrays: "dict[str, np.ndarray]", attributes: dict[str, Any]) -> "Recording":
        """Name, unit and meaning to every array; a variable that is missing or unknown is an error."""
        import xarray as xr

        known = VARIABLES | (CONTACT_VARIABLES if "contact_count" in arrays else {})
        known |= RIM_VARIABLES if "rim_x" in arrays else {}
        known |= SLAB_VARIABLES if "position_y" in arrays else {}
        if set(arrays) != set(known):
            raise ValueError(f"variables missing or unknown: {sorted(set(arrays) ^ set(known))}")
        variables: dict[str, Any] = {
            name: (dims, arrays[name], {"units": unit, "long_name": meaning})
            for name, (dims, unit, meaning) in known.items()
        }
        if "contact_count" in variables:  # as the CF conventions say which dimension is ragged
            variables["contact_count"][2]["sample_dimension"] = "contact"
        return cls(xr.Dataset(variables, attrs={"schema_version": SCHEMA_VERSION, **attributes}))

    @classmethod
    def read(cls, path: str | Path) -> "Recording":
        """Read `recording.nc` whole into memory.

        Raises
        ------
        ValueError
            Not a recording, or one of another schema version.
        """
        with _opened(path) as data:
            try:
                return cls(data.load())
            except Exception as error:
                raise ValueError(f"{path}: not a recording: {error}") from None

    @classmethod
    @contextlib.contextmanager
    def open(cls, path: str | Path) -> Iterator["Recording"]:
        """Use a recording without reading what it says of particles, until `states` asks for it.

        It needs the memory of a frame or two, however many it has. Raises what `read` does.
        """
        with _opened(path) as data:
            small = [
                name
                for name, one in data.data_vars.items()
                if one.dims != ("frame", "particle") and one.dims != ("contact",)
            ]
            yield cls(data.assign({name: data[name].load() for name in small}))

    def states(self, name: str, frame: int) -> "np.ndarray":
        """A variable of the particles at one frame, (particle,): the others are not read."""
        return self.data[name].isel(frame=frame).values

    def write(self, path: str | Path) -> None:
        """Write `recording.nc` (netCDF-4, compressed without loss), so that a frame is read by itself."""
        encoding: dict[Any, dict[str, Any]] = {}
        for name, one in self.data.data_vars.items():
            encoding[name] = {"zlib": True, "complevel": 1, "shuffle": True}
            if one.dims == ("frame", "particle") and one.size:
                encoding[name]["chunksizes"] = (1, one.sizes["particle"])
        require_space(Path(path), self.data.nbytes)
        self.data.to_netcdf(path, engine="h5netcdf", encoding=encoding)

    def write_forces(self, path: str | Path) -> None:
        """Write `forces.csv`: one line a record, units in the header."""
        units = {name: unit for name, (_, unit, _) in (VARIABLES | RIM_VARIABLES).items()}
        names = FORCE_COLUMNS | {name: name for name in RIM_COLUMNS if name in self.data}
        columns = {f"{column} [{units[name]}]": self.data[name].values for column, name in names.items()}
        with Path(path).open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(columns)
            writer.writerows([f"{value:.9g}" for value in row] for row in zip(*columns.values(), strict=True))

    def section(self, shape: "Shape", frame: int) -> "Shape":
        """An implement's `shape` as it stands at a frame about its reference point: turned, or deformed."""
        import numpy as np

        from synth.implements.compliant_wheel import rim_shape

        state = self.data.isel(frame=frame)
        if "rim_x" not in state:
            return shape.turned(float(state["implement_angle"]))
        at = float(state["implement_x"]), float(state["implement_z"])
        nodes = np.stack([state["rim_x"].values, state["rim_z"].values], axis=1) - at
        return rim_shape(nodes, float(shape.radius[0]))

    def contacts(self, frame: int) -> "xr.Dataset | None":
        """The forces between particles at a frame, over `contact`; None where they were not recorded."""
        if "contact_count" not in self.data:
            return None
        count = self.data["contact_count"].values
        start = int(count[:frame].sum())
        names = [name for name, (dims, _, _) in CONTACT_VARIABLES.items() if dims == ("contact",)]
        return self.data[names].isel(contact=slice(start, start + int(count[frame])))

    def at_glass(self) -> "Recording":
        """What a camera before the glass sees: of a slab, the particles that are at the glass on average.

        Others come into sight and leave it as they move across the slab; a picture's truth needs particles
        that are there throughout. Discs are all at the glass.
        """
        if "position_y" not in self.data:
            return self
        total = sum(self.states("position_y", frame) for frame in range(self.frame_count))
        gap = total / self.frame_count - self.data["radius"].values
        near = gap <= AT_GLASS * 2 * float(self.data["radius"].mean())
        return Recording(self.data.isel(particle=near))

    @property
    def frame_count(self) -> int:
        """Number of recorded frames."""
        return self.data.sizes["frame"]

    @property
    def digest(self) -> str:
        """SHA-256 over the values of every variable, in the order above, hexadecimal."""
        import hashlib

        digest = hashlib.sha256()
        for name in VARIABLES | RIM_VARIABLES | CONTACT_VARIABLES | SLAB_VARIABLES:
            if name in self.data:
                digest.update(self.data[name].values.tobytes())
        return digest.hexdigest()
