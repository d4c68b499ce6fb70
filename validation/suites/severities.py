"""Named sets of nuisances: what a suite's pictures suffer from."""

import math
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

CLEAN = "clean"
PAPER = "paper"
PAPER_FILE = Path(__file__).parents[1] / "reference" / "paper_severity.toml"
"""Tuned on `plate_rotation` alone until `soft-2014` shows the published error there, then frozen."""
_LEVELS = {"light": 0, "heavy": 2}
"""Which of the nuisance study's severities every nuisance has, all at once."""


_FULL_WELL = 20_000.0
"""electrons at full scale of `plate_rotation`'s sensor, with which `paper` was found."""


class SeverityError(ValueError):
    """A severity that does not exist; the message is one line."""


def severity_names() -> tuple[str, ...]:
    """Those that exist."""
    return (CLEAN, *_LEVELS, *([PAPER] if PAPER_FILE.is_file() else []))


def severity_changes(name: str, scene: Mapping[str, Any] | None = None) -> tuple[tuple[str, str, Any], ...]:
    """What it changes in a scene: (table, key, value) each.

    Parameters
    ----------
    name : str
    scene : mapping, optional
        Its tables. The sensor of a motion by formula tells all of its noise in grey levels: there read noise
        is added to that.

    Raises
    ------
    SeverityError
        There is none of this name.
    """
    if name == CLEAN:
        return ()
    if name in _LEVELS:
        from validation.studies.nuisance import SEVERITIES

        return tuple(("nuisance", key, values[_LEVELS[name]]) for key, values in SEVERITIES.items())
    if name == PAPER and PAPER_FILE.is_file():
        tables = tomllib.loads(PAPER_FILE.read_text(encoding="utf-8"))
        changes = tuple((t, key, value) for t, keys in tables.items() for key, value in keys.items())
        own = (scene or {}).get("sensor", {}).get("noise")
        return changes if own is None else tuple(_in_grey_levels(own, *change) for change in changes)
    raise SeverityError(f"severity {name!r}: allowed are {', '.join(severity_names())}")


def _in_grey_levels(own: float, table: str, key: str, value: Any) -> tuple[str, str, Any]:
    if (table, key) != ("sensor", "read_noise"):
        return table, key, value
    return table, "noise", round(math.hypot(own, value / _FULL_WELL * 255), 3)
