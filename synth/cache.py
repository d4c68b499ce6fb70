"""Numbers that took long to compute, kept under the cache folder by the hash of what they were made from."""

import hashlib
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from synth.devices import cache_folder
from synth.disk import written_whole
from synth.locks import sole_maker
from synth.text_files import read_json


def cached(kind: str, made_from: Mapping[str, Any], compute: Callable[[], Any]) -> Any:
    """A JSON value from the cache, or computed now and kept: once, by whichever process comes first.

    Parameters
    ----------
    kind : str
        Folder under the cache folder.
    made_from : mapping
        All that the value depends on, the version of its recipe among it; JSON.
    compute : callable
        Gives the value; JSON.
    """
    path = _path(kind, made_from)
    if (kept := _read(path)) is not None:
        return kept["value"]
    with sole_maker(path):
        if (kept := _read(path)) is not None:  # another process has made it meanwhile
            return kept["value"]
        value = compute()
        _write(path, {"made_from": dict(made_from), "value": value})
        return value


def _read(path: Path) -> dict[str, Any] | None:
    """A document; None where it is not there, or damaged."""
    try:
        document = read_json(path)
    except (OSError, ValueError):
        return None
    return document if isinstance(document, dict) and "value" in document else None


def _path(kind: str, made_from: Mapping[str, Any]) -> Path:
    canonical = json.dumps(dict(made_from), sort_keys=True, allow_nan=False)
    return cache_folder() / kind / f"{hashlib.sha256(canonical.encode()).hexdigest()}.json"


def _write(path: Path, document: dict[str, Any]) -> None:
    with written_whole(path) as draft:
        draft.write_text(json.dumps(document, allow_nan=False), encoding="utf-8")
