"""All measurements of a suite, each file opened once: lines of the table, error profiles, worst places."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from validation.suites.execution import is_measured, measured_file
from validation.suites.measurement_file import read_measurement
from validation.suites.plan import Look, Suite
from validation.suites.table import Line, lines_of

if TYPE_CHECKING:
    import xarray as xr

_PROFILE = ("count_", "unmeasured_", "sums_")
_RESPONSE = ("response_",)
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
            yield look, read_measurement(measured_file(out, look))


def _keep_worst(worst: "dict[tuple[str, str], xr.Dataset]", look: Look, measured: "xr.Dataset") -> None:
    key = look.realisation.motion.scene, look.method
    if key not in worst or measured.attrs["worst_mean"] > worst[key].attrs["worst_mean"]:
        worst[key] = measured[list(_WORST)].copy()
