"""Named sets of nuisances: what a suite's pictures suffer from."""

import tomllib
from pathlib import Path
from typing import Any

CLEAN = "clean"
PAPER = "paper"
PAPER_FILE = Path(__file__).parents[1] / "reference" / "paper_severity.toml"
"""Tuned on `plate_rotation` alone until `soft-2014` shows the published error there, then frozen."""
_LEVELS = {"light": 0, "heavy": 2}
"""Which of the nuisance study's severities every nuisance has, all at once."""


class SeverityError(ValueError):
    """A severity that does not exist; the message is one line."""


def severity_names() -> tuple[str, ...]:
    """Those that exist."""
    return (CLEAN, *_LEVELS, *([PAPER] if PAPER_FILE.is_file() else []))


def severity_changes(name: str) -> tuple[tuple[str, str, Any], ...]:
    """What it changes in a scene: (table, key, value) each.

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
        return tuple((t, key, value) for t, keys in tables.items() for key, value in keys.items())
    raise SeverityError(f"severity {name!r}: allowed are {', '.join(severity_names())}")
