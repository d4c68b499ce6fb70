"""TOML and JSON files as people send them."""

import json
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

T = TypeVar("T")

_TOO_DEEP = "nested too deeply"
_LONGEST_SHOWN = 60
_OBJECT = "a JSON object is needed"
_PLAINLY = {
    "missing": "missing",
    "unexpected_keyword_argument": "unknown key",
    "dataclass_type": _OBJECT,
    "dict_type": _OBJECT,
    "list_type": "a list is needed",
    "string_type": "a text is needed",
    "float_type": "a number is needed",
    "int_type": "a whole number is needed",
}
"""What pydantic says by naming types of Python."""


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


def read_json_object(path: Path, *, schema_version: int | None = None) -> dict[str, Any]:
    """Read a file's JSON object; ValueError, without the path, says what it holds instead."""
    told = read_json(path)
    if not isinstance(told, dict):
        raise ValueError(_OBJECT)
    if schema_version is None:
        return told
    if "schema_version" not in told:
        raise ValueError("schema_version: missing")
    if told["schema_version"] != schema_version:
        found = _shown(told["schema_version"])
        raise ValueError(f"schema_version{found}: this program reads {schema_version}")
    return told


def checked(kind: type[T], told: Any, *, name: str = "") -> T:
    """What JSON tells as a dataclass, and others in it.

    Parameters
    ----------
    name : str
        Key of what is told, in front of every complaint.

    Raises
    ------
    ValueError
        With the key, its value and what is needed, in one line.
    """
    from pydantic import TypeAdapter, ValidationError

    try:
        return TypeAdapter(kind).validate_python(told)
    except ValidationError as error:
        raise ValueError(_plainly(error.errors(include_url=False)[0], name)) from None


def _plainly(fault: "ErrorDetails", name: str) -> str:
    key = ".".join(str(part) for part in (name, *fault["loc"]) if part != "")
    said = _PLAINLY.get(fault["type"], fault["msg"].removeprefix("Value error, "))
    value = "" if fault["type"] == "missing" else _shown(fault["input"])
    return f"{key}{value}: {said}" if key else said


def _shown(value: Any) -> str:
    """What is no number, text, truth or nothing is not shown."""
    if isinstance(value, dict | list):
        return ""
    text = json.dumps(value)
    return f" = {text}" if len(text) <= _LONGEST_SHOWN else f" = {text[:_LONGEST_SHOWN]}..."
