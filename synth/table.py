"""The base of every table of a scene file, and what its keys are."""

from collections.abc import Sequence
from typing import Any, get_args

from pydantic import BaseModel, ConfigDict


class Table(BaseModel):
    """A table of a scene file: unknown keys, infinities, NaN and values of another type are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=True)


def kinds_of(tables: Any) -> list[str]:
    """The `kind` of each table of an annotated union."""
    union = get_args(tables)[0]
    return [get_args(table.model_fields["kind"].annotation)[0] for table in get_args(union)]


def unknown_key(tables: Any, location: Sequence[str | int]) -> str:
    """Say that there is no such key, and which there are beside it.

    Parameters
    ----------
    tables : type
        The outermost table, or a union of such.
    location : sequence
        Where a validation error says that the unknown key stands.
    """
    found = _tables_in(tables)
    for part in location[:-1]:
        of_this_kind = [table for table in found if _is_of_kind(table, part)]
        inner = [table.model_fields[part].annotation for table in found if part in table.model_fields]
        # Where a part is neither, it is a place in a list or a key of a mapping of tables.
        found = of_this_kind or [table for one in inner for table in _tables_in(one)] or found
    allowed = sorted({key for table in found for key in table.model_fields})
    return f"unknown key, allowed are {', '.join(allowed)}" if allowed else "unknown key"


def _tables_in(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [table for argument in get_args(annotation) for table in _tables_in(argument)]


def _is_of_kind(table: type[BaseModel], kind: str | int) -> bool:
    return "kind" in table.model_fields and kind in get_args(table.model_fields["kind"].annotation)
