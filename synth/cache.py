"""Numbers that took long to compute, kept under the cache folder by the hash of what they were made from."""

import hashlib
import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from synth.devices import cache_folder


def cached(kind: str, made_from: Mapping[str, Any], compute: Callable[[], Any]) -> Any:
    """A JSON value from the cache, or computed now and kept.

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
    try:
        return json.loads(path.read_text(encoding="utf-8"))["value"]
    except (OSError, ValueError, KeyError, TypeError):
        pass  # not there, or damaged: made anew
    value = compute()
    _write(path, {"made_from": dict(made_from), "value": value})
    return value


def _path(kind: str, made_from: Mapping[str, Any]) -> Path:
    canonical = json.dumps(dict(made_from), sort_keys=True, allow_nan=False)
    return cache_folder() / kind / f"{hashlib.sha256(canonical.encode()).hexdigest()}.json"


def _write(path: Path, document: dict[str, Any]) -> None:
    """Written aside and renamed: a value in the cache is whole."""
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = path.with_name(f".{path.stem}-{os.getpid()}.json")
    aside.write_text(json.dumps(document, allow_nan=False), encoding="utf-8")
    aside.replace(path)
