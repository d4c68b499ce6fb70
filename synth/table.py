"""The base of every table of a scene file."""

from pydantic import BaseModel, ConfigDict


class Table(BaseModel):
    """A table of a scene file: unknown keys, infinities and NaN are refused, and nothing changes later."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
