"""Settings of an analysis, as a TOML file holds them: every key documented, unknown ones refused."""

from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from soft.toml_file import read_toml

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Point = tuple[float, float]

_HEADER = """\
# Settings of `softbed analyze PATH --settings FILE`. What is left out has its default; options of the
# command line go before. Keys that begin with # have no default: an example is shown. Paths are relative to
# this file.
"""


class SettingsError(ValueError):
    """A settings file that cannot be used; the message is one line that names the key."""


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class FrameSettings(_Table):
    """Which pictures are compared with which."""

    start: int = Field(0, ge=0, description="frame of the first pair; the first picture is 0")
    stop: int | None = Field(None, ge=1, description="frames from this one on are not used", examples=[100])
    stride: int = Field(1, ge=1, description="frames from the first picture of a pair to its second")
    every: int = Field(1, ge=1, description="frames from one pair's first picture to the next pair's")
    frame_rate: Positive | None = Field(
        None, description="1/s; else as sequence.toml or the video tells it", examples=[8.0]
    )


class CalibrationSettings(_Table):
    """From pixels to metres: one of metres_per_pixel, scale_points and glass_points; and the lens."""

    metres_per_pixel: Positive | None = Field(None, description="pixel size on the glass, m", examples=[2e-4])
    scale_points: tuple[Point, Point] | None = Field(
        None,
        description="[x, y] px of both ends of a length on the glass",
        examples=[[[100, 420], [900, 420.5]]],
    )
    scale_length: Positive | None = Field(None, description="that length, m", examples=[0.16])
    glass_points: tuple[tuple[float, float, float, float], ...] | None = Field(
        None,
        description="four or more points on the glass: x and y in px, x along the bin and z up in m",
        examples=[[[100, 420, 0, 0], [900, 421, 0.16, 0], [897, 60, 0.16, 0.072], [103, 61, 0, 0.072]]],
    )
    rectify: bool = Field(False, description="see the glass square; needs glass_points")
    lens: Path | None = Field(
        None, description="lens file of `softbed calibrate-camera`", examples=["lens.toml"]
    )

    @model_validator(mode="after")
    def _one_scale(self) -> Self:
        given = [
            key
            for key in ("metres_per_pixel", "scale_points", "glass_points")
            if getattr(self, key) is not None
        ]
        if len(given) > 1:
            raise ValueError(f"{' and '.join(given)}: only one of them can give the pixel size")
        if (self.scale_points is None) != (self.scale_length is None):
            raise ValueError("scale_points and scale_length: one needs the other")
        if self.rectify and self.glass_points is None:
            raise ValueError("rectify: needs glass_points")
        return self


class RegionSettings(_Table):
    """The part of the picture that is used, in px after the lens and the tilt are taken out."""

    x: int = Field(ge=0, description="column of its upper left pixel", examples=[0])
    y: int = Field(ge=0, description="row of its upper left pixel", examples=[0])
    width: int = Field(ge=2, description="columns", examples=[1000])
    height: int = Field(ge=2, description="rows", examples=[500])


class SoilSettings(_Table):
    """Where soil is."""

    kind: Literal["bright", "dark", "all"] = Field(
        "bright", description="bright or dark soil before the rest, or all: nothing but soil (in the masks)"
    )
    masks: Path | None = Field(
        None,
        description="a picture (png, tif, bmp) for all frames or a folder of one each; black is never soil",
        examples=["mask.png"],
    )


class CameraSettings(_Table):
    """The camera's own motion."""

    motion: Literal["median", "mode", "far"] = Field(
        "median",
        description="median over soil; or, where over half of it moves, mode: what most soil shares, "
        "or far: what motion tends to far from where soil moves fastest",
    )
    vertical: bool = Field(False, description="take its vertical motion out, too")


class FlowSettings(_Table):
    """How motion is measured."""

    method: str = Field("robust-affine", description="a built-in method")
    options: dict[str, Any] = Field(
        default_factory=dict, description="options of the method, by name", examples=[{}]
    )
    seed: int = Field(0, ge=0, description="of the random starts of k-means")

    @model_validator(mode="after")
    def _built_in(self) -> Self:
        from soft.flow import BUILT_IN

        # A file that somebody sent must not choose what code runs.
        if self.method not in BUILT_IN:
            raise ValueError(
                f"method {self.method!r}: allowed are {', '.join(BUILT_IN)}; "
                "any other is given on the command line only"
            )
        return self


class AnalysisSettings(_Table):
    """All settings of an analysis."""

    frames: FrameSettings = FrameSettings()
    calibration: CalibrationSettings = CalibrationSettings()
    region: RegionSettings | None = None
    soil: SoilSettings = SoilSettings()
    camera: CameraSettings = CameraSettings()
    flow: FlowSettings = FlowSettings()

    @classmethod
    def read(cls, path: str | Path) -> "AnalysisSettings":
        """Read a TOML file; paths in it are relative to its folder.

        Raises
        ------
        SettingsError
            It is missing or no TOML, or a key is unknown or its value not allowed.
        """
        path = Path(path)
        try:
            table = read_toml(path)
        except FileNotFoundError:
            raise SettingsError(f"{path}: no such file") from None
        except (OSError, ValueError) as error:
            raise SettingsError(f"{path}: not a TOML file: {error}") from error
        for section, key in (("calibration", "lens"), ("soil", "masks")):
            if isinstance(table.get(section), dict) and isinstance(table[section].get(key), str):
                table[section][key] = str(path.parent / table[section][key])
        return cls.checked(table, name=str(path))

    @classmethod
    def checked(cls, table: dict[str, Any], *, name: str) -> "AnalysisSettings":
        """Make settings of nested tables.

        Parameters
        ----------
        name : str
            What to call them in an error message.

        Raises
        ------
        SettingsError
            A key is unknown or its value not allowed.
        """
        try:
            return cls.model_validate(table)
        except ValidationError as error:
            raise SettingsError(f"{name}: {_complaint(error)}") from None

    def changed(self, *, name: str = "settings", **sections: dict[str, Any] | None) -> "AnalysisSettings":
        """Put other values in the place of some, checked like those of a file; None changes nothing.

        Parameters
        ----------
        name : str
            What to call them in an error message.
        **sections
            For a section's name, values by key; those that are None change nothing.
        """
        table = self.model_dump(exclude_none=True)
        for section, values in sections.items():
            given = {key: value for key, value in (values or {}).items() if value is not None}
            table[section] = table.get(section, {}) | given
        return self.checked(
            {key: value for key, value in table.items() if value or key != "region"}, name=name
        )

    def rooted(self) -> "AnalysisSettings":
        """With absolute paths, which mean the same in any folder."""
        lens, masks = self.calibration.lens, self.soil.masks
        return self.changed(
            calibration={"lens": None if lens is None else lens.absolute()},
            soil={"masks": None if masks is None else masks.absolute()},
        )

    def to_dict(self) -> dict[str, Any]:
        """As JSON can hold them, without those that have no value."""
        return self.model_dump(mode="json", exclude_none=True)


def _complaint(error: ValidationError) -> str:
    """The first fault: key, value, what is allowed."""
    faults = error.errors(include_url=False)
    # A misspelt key is told before the key that is missing because of it.
    fault = min(faults, key=lambda one: one["type"] != "extra_forbidden")
    kind, value, key = fault["type"], fault["input"], ".".join(str(part) for part in fault["loc"])
    if kind == "extra_forbidden":
        return f"{key}: there is no such key"
    if kind == "missing":
        return f"{key}: is missing"
    shown = "" if isinstance(value, dict) else f" = {value!r}"
    said = fault["msg"].removeprefix("Value error, ").replace("Input should be", "must be")
    return f"{key}{shown}: {'must be a table' if kind == 'model_type' else said}"


def settings_template() -> str:
    """All settings with their defaults and what they mean, as TOML."""
    lines = [_HEADER]
    for section, field in AnalysisSettings.model_fields.items():
        optional = section == "region"
        table = RegionSettings if optional else type(field.default)
        lines += [f"# {table.__doc__}", f"# [{section}]" if optional else f"[{section}]"]
        lines += [_line(key, value) for key, value in table.model_fields.items()]
        lines.append("")
    return "\n".join(lines)


def write_settings(path: str | Path) -> None:
    """Write `settings_template` to a new file.

    Raises
    ------
    SettingsError
        There is a file of this name.
    """
    try:
        with Path(path).open("x", encoding="utf-8") as file:
            file.write(settings_template())
    except FileExistsError:
        raise SettingsError(f"{path}: exists already: nothing is overwritten, choose another name") from None


def _line(key: str, field: Any) -> str:
    import tomli_w

    has_default = not field.is_required() and field.get_default(call_default_factory=True) is not None
    value = field.get_default(call_default_factory=True) if has_default else field.examples[0]
    written = tomli_w.dumps({key: value}) if not isinstance(value, dict) else f"{key} = {{}}"
    line = " ".join(written.split()).replace("[ ", "[").replace(", ]", "]")
    return f"{'' if has_default else '# '}{line}  # {field.description}"
