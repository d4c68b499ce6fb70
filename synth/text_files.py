"""TOML and JSON files as people send them."""

import json
import tomllib
from pathlib import Path
from typing import Any

_TOO_DEEP = "nested too deeply"


def read_toml(path: Path) -> dict[str, Any]:
    """Read a file's tables; ValueError, without the path, says why that is no TOML."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except RecursionError:
        raise ValueError(_TOO_DEEP) from None


def read_json(path: Path) -> Any:
    """Read a file's value; ValueError, without the path, says why that is no JSON."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except RecursionError:
        raise ValueError(_TOO_DEEP) from None
