"""All measurements of a suite, each file opened once: lines of the table, error profiles, worst places."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.suites.execution import is_measured, measured_file
from validation.suites.plan import Look, Suite
from validation.suites.table import ERRORS, Line, lines_of

if TYPE_CHECKING:
    import xarray as xr

_PROFILE = ("count_", "unmeasured_", "sums_")
_RESPONSE = ("response_",)
_WORST_DIMENSIONS = ("worst_y", "worst_x")
_WORST = ("worst_picture", "worst_speed", "worst_error")


@dataclass(eq=False)
class Gathered:
    """What a suite has measured.

    Attributes
    ----------
    looks : list of Look
        Those that are there.
    lines : list of dict
        The table.
    profiles : list of (Look, xarray.Dataset)
        Error profile of every look, and the response where it has one.
    worst : dict
        For each scene and method, what is around the place where it fails most, at any look.
    """

    looks: list[Look] = field(default_factory=list)
    lines: list[Line] = field(default_factory=list)
    profiles: "list[tuple[Look, xr.Dataset]]" = field(default_factory=list)
    worst: "dict[tuple[str, str], xr.Dataset]" = field(default_factory=dict)

    def summed(self, severity: str, prefix: str | tuple[str, ...]) -> "dict[str, xr.Dataset]":
        """For each method, variables of these prefixes added up over scenes as they are usually seen."""
        found: dict[str, xr.Dataset] = {}
        for look, profile in self.profiles:
            realisation = look.realisation
            if realisation.severity != severity or not realisation.is_usual:
                continue
            names = [str(name) for name in profile.data_vars if str(name).startswith(prefix)]
            if names:
                one = profile[names]
                found[look.method] = found[look.method] + one if look.method in found else one
        return found


def gather(suite: Suite, out: Path) -> Gathered:
    """Read all measurements of a suite that are there, made by these versions."""
    found = Gathered()
    for look, measured in _measured(suite, out):
        found.looks.append(look)
        found.lines += lines_of(measured)
        chosen = [name for name in measured.data_vars if str(name).startswith((*_PROFILE, *_RESPONSE))]
        if chosen:
            found.profiles.append((look, measured[chosen].copy()))
        if _WORST[0] in measured:
            _keep_worst(found.worst, look, measured)
    return found


def _measured(suite: Suite, out: Path) -> "Iterator[tuple[Look, xr.Dataset]]":
    for look in suite.looks:
        if is_measured(out, look):
            yield look, _read(measured_file(out, look))


def _read(path: Path) -> "xr.Dataset":
    """Read a measurement; ten times faster than xarray finds out what is in such a file."""
    import h5py
    import xarray as xr

    with h5py.File(path) as file:
        wanted = {name: _dimensions(name) for name in file}
        variables = {
            name: (dimensions, _decoded(file[name])) for name, dimensions in wanted.items() if dimensions
        }
        return xr.Dataset(variables, attrs={name: _plain(value) for name, value in file.attrs.items()})


def _dimensions(name: str) -> tuple[str, ...]:
    """Of a variable of a measurement, as `validation.suites.measurement` makes it; none for others."""
    if name in ("pair", "stratum", "bound", "period"):
        return () if name == "pair" else (name,)
    if name in ERRORS:
        return "pair", "stratum"
    for prefix, dimensions in _PREFIXES.items():
        if name.startswith(prefix):
            return tuple(one.format(name.removeprefix(prefix)) for one in dimensions)
    return ()


_PREFIXES = {
    "wrong_share": ("pair", "stratum", "bound"),
    "seconds": ("pair",),
    "count_": ("bin_{}", "error_bin"),
    "unmeasured_": ("bin_{}",),
    "sums_": ("bin_{}", "moment"),
    "response_": ("period",),
    "worst_picture": _WORST_DIMENSIONS,
    "worst_speed": _WORST_DIMENSIONS,
    "worst_error": _WORST_DIMENSIONS,
}


def _decoded(variable: Any) -> Any:
    return variable.asstr()[...] if variable.dtype.kind in "OS" else variable[...]


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.ndarray) and value.size == 1 else value


def _keep_worst(worst: "dict[tuple[str, str], xr.Dataset]", look: Look, measured: "xr.Dataset") -> None:
    key = look.realisation.motion.scene, look.method
    if key not in worst or measured.attrs["worst_mean"] > worst[key].attrs["worst_mean"]:
        worst[key] = measured[list(_WORST)].copy()
