"""The base of every table of a scene file."""

from typing import Any, get_args

from pydantic import BaseModel, ConfigDict


class Table(BaseModel):
    """A table of a scene file: unknown keys, infinities, NaN and values of another type are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=True)


def kinds_of(tables: Any) -> list[str]:
    """The `kind` of each table of an annotated union."""
    union = get_args(tables)[0]
    return [get_args(table.model_fields["kind"].annotation)[0] for table in get_args(union)]
