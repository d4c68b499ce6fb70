"""What a sweep is: a TOML file that says which keys of a scene are varied, and how."""

from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Discriminator, Field, Tag, ValidationError, model_validator

from synth.scene import AnyScene, SceneError, load_scene
from synth.scene_files import scene_names, study_scene_names
from synth.table import Table, unknown_key
from synth.text_files import read_toml

SCHEMA_VERSION = 1
SPLITS = ("train", "validation", "test")
_TOLERANCE = 1e-9


class SweepError(ValueError):
    """A sweep that cannot be used; the message names file, key, value and what is allowed."""


class Span(Table):
    """Values between two ends."""

    low: float | int
    high: float | int
    scale: Literal["linear", "log"] = "linear"
    integer: bool = Field(default=False, description="whole numbers only, both ends among them")
    count: int | None = Field(default=None, ge=2, le=100_000, description="of a grid: how many values")

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if not self.low < self.high:
            raise ValueError(f"low < high is needed, got {self.low} and {self.high}")
        if self.scale == "log" and self.low <= 0:
            raise ValueError(f"scale = 'log': low > 0 is needed, got {self.low}")
        if self.integer and not (float(self.low).is_integer() and float(self.high).is_integer()):
            raise ValueError(f"integer: whole numbers are needed, got {self.low} and {self.high}")
        return self


class Design(Table):
    """How points are laid out among the values."""

    kind: Literal["grid", "latin_hypercube", "sobol"]
    count: int | None = Field(default=None, ge=1, le=1_000_000, description="of random designs: points")

    @model_validator(mode="after")
    def _counts_where_it_must(self) -> Self:
        if (self.count is None) != (self.kind == "grid"):
            what = "follows from the values, leave it out" if self.kind == "grid" else "missing"
            raise ValueError(f"kind = {self.kind!r}: count {what}")
        return self


class Split(Table):
    """Shares of the simulations; all members of one motion are in one split."""

    train: float = Field(default=0.8, ge=0, le=1)
    validation: float = Field(default=0.1, ge=0, le=1)
    test: float = Field(default=0.1, ge=0, le=1)

    @model_validator(mode="after")
    def _is_everything(self) -> Self:
        total = sum(getattr(self, name) for name in SPLITS)
        if abs(total - 1) > _TOLERANCE:
            raise ValueError(f"train + validation + test = 1 is needed, got {total:g}")
        return self


def _kind_of_values(given: Any) -> str:
    return "span" if isinstance(given, dict | Span) else "values"


Values = Annotated[
    Annotated[list[Any], Tag("values")] | Annotated[Span, Tag("span")], Discriminator(_kind_of_values)
]


class Sweep(Table):
    """A sweep file.

    Attributes
    ----------
    scene : str
        A shipped scene, or a TOML file beside the sweep's: what all members have in common.
    seed : int
        Of the design, of the splits and of the members' textures; the beds' is the scene's own key `seed`.
    vary : dict
        By dotted key of the scene: a list of values, or a `Span`. A list of one sets a key for all members.
    """

    schema_version: Literal[1]
    name: str = Field(pattern=r"^[A-Za-z0-9_\-]+$")
    description: str = ""
    scene: str
    quick: bool = False
    seed: int = Field(default=0, ge=0, lt=2**63)
    design: Design
    vary: dict[str, Values] = Field(min_length=1)
    split: Split = Split()

    @model_validator(mode="after")
    def _has_values(self) -> Self:
        for key, values in self.vary.items():
            if isinstance(values, list) and not values:
                raise ValueError(f"vary.{key}: one value or more is needed")
            if isinstance(values, Span) and (values.count is None) == (self.design.kind == "grid"):
                needed = "needs" if self.design.kind == "grid" else "has no"
                raise ValueError(f"vary.{key}: a span of the design {self.design.kind!r} {needed} count")
        return self

    def to_toml(self, *, scene: str) -> str:
        """The sweep as TOML, of a scene of another name."""
        import tomli_w

        tables = self.model_dump(mode="json", exclude_none=True)
        return tomli_w.dumps({**tables, "scene": scene})


def load_sweep(path: str | Path) -> tuple[Sweep, AnyScene]:
    """Read a sweep file, and the scene that it varies.

    Raises
    ------
    SweepError
        With file, key, value and what is allowed.
    synth.scene.SceneError
        The scene cannot be used.
    """
    path = Path(path)
    try:
        tables = read_toml(path)
    except OSError as error:
        raise SweepError(f"{path}: {error.strerror}") from None
    except ValueError as error:
        raise SweepError(f"{path}: not TOML: {error}") from None
    if isinstance(tables.get("vary"), dict):
        tables["vary"] = dict(_flat(tables["vary"]))
    try:
        sweep = Sweep.model_validate(tables)
    except ValidationError as error:
        raise SweepError(f"{path}: {_complaint(error)}") from None
    return sweep, _base_scene(sweep, path)


def _base_scene(sweep: Sweep, path: Path) -> AnyScene:
    shipped = sweep.scene in scene_names() + study_scene_names()
    try:
        return load_scene(sweep.scene if shipped else path.parent / sweep.scene, quick=sweep.quick)
    except SceneError as error:
        raise SweepError(f"{path}: scene = {sweep.scene!r}: {error}") from None


def _flat(tables: dict[str, Any], within: str = "") -> "list[tuple[str, Any]]":
    """Values by dotted key, whether it is quoted ("drive.slip" = ...) or tables nest (drive.slip = ...)."""
    found = []
    for key, value in tables.items():
        if isinstance(value, dict) and not {"low", "high"} & set(value):
            found += _flat(value, f"{within}{key}.")
        else:
            found.append((f"{within}{key}", value))
    return found


def _complaint(error: ValidationError) -> str:
    """The first fault in one line."""
    faults = error.errors(include_url=False)
    fault = min(faults, key=lambda one: one["type"] != "extra_forbidden")
    key = ".".join(str(part) for part in fault["loc"] if part not in ("values", "span"))
    if fault["type"] == "missing":
        return f"{key}: missing"
    if fault["type"] == "extra_forbidden":
        return f"{key}: {unknown_key(Sweep, fault['loc'])}"
    shown = "" if isinstance(fault["input"], dict) else f" = {fault['input']!r}"
    if fault["type"] == "list_type":
        return f"{key}{shown}: a list of values, or a table with low and high, is needed"
    said = fault["msg"].removeprefix("Value error, ")
    return f"{key}{shown}: {said}" if key else said
