"""What an experiment is: a TOML file in, a resolved scene with every number in it out."""

import hashlib
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, TypeAdapter, ValidationError, model_validator

from synth.analytic.motion import Motion
from synth.analytic.settings import (
    AnalyticCamera,
    AnalyticLens,
    AnalyticSensor,
    AnalyticTiming,
    GaussianGrains,
)
from synth.camera.settings import Camera, Lens, Light, Nuisance, Sensor, Texture
from synth.drive import Drive, Program
from synth.implements import CompliantWheel, Implement, Plate
from synth.scene_files import scene_names, scenes_folder, soil_names, study_scene_names
from synth.soil import Soil, SoilFile
from synth.table import Table, kinds_of, unknown_key
from synth.text_files import read_toml

SCHEMA_VERSION = 1
GRAVITY = 9.81
"""Acceleration of gravity on Earth, m/s2, where a scene does not say otherwise."""

_LOOSEST = 0.74
"""Solid fraction of discs, at least."""
_PICTURE_TABLES = {"camera", "texture", "light", "lens", "sensor", "nuisance", "grains"}
_LABELS = {"name", "description", "quick", "data_licence"}
_PICTURES_ALONE = _PICTURE_TABLES | {"picture_seed"}
_LONGEST_SHOWN = 80
"""Characters of a value that a complaint shows."""
_RIVALS = {"settling_friction": "relative_density", "relative_density": "settling_friction"}
"""Keys that exclude each other: a file that gives one takes the other one's place in its base."""


class SceneError(ValueError):
    """A scene that cannot be used; the message names file, key, value and what is allowed."""


class FineRegion(Table):
    """Where a bed's grains are finest: between two verticals, from a height up to the surface."""

    left: float = Field(description="m, from the left end wall")
    right: float = Field(description="m, from the left end wall")
    bottom: float = Field(description="m, above the floor")

    @model_validator(mode="after")
    def _has_a_width(self) -> Self:
        if not self.left < self.right:
            raise ValueError(f"left < right is needed, got {self.left} and {self.right} m")
        return self


class Bed(Table):
    """The soil bed as it is prepared."""

    width: float = Field(gt=0, le=5, description="m, between the end walls")
    depth: float = Field(gt=0, le=2, description="m, from the floor to the levelled surface")
    grain_diameter: float = Field(gt=0, description="m, mean diameter of the simulated particles")
    polydispersity: float = Field(
        ge=0, le=0.5, description="half-width of the uniform spread / mean diameter"
    )
    coarsening: float = Field(
        default=1.0,
        ge=1,
        le=8,
        description="mean diameter of the coarsest grains / grain_diameter; coarser away from `fine`",
    )
    fine: FineRegion | None = Field(
        default=None,
        description="where grains are of grain_diameter; default: what is seen and worked",
    )
    settling_friction: float | None = Field(
        default=None, ge=0, le=2, description="grain friction while settling; sets the density"
    )
    relative_density: float | None = Field(
        default=None, ge=0, le=1, description="to prepare the bed at: 0 loosest, 1 densest"
    )
    gravity: float = Field(default=GRAVITY, gt=0, le=100, description="m/s2, downwards")
    thickness: float = Field(
        default=0.0,
        ge=0,
        le=1,
        description="m, of a slab of spheres, from the glass to a mirror; 0: discs in plane strain",
    )
    glass_friction: float = Field(default=0.3, ge=0, le=2, description="of spheres on the glass")

    @model_validator(mode="after")
    def _prepared_in_one_way(self) -> Self:
        if (self.settling_friction is None) == (self.relative_density is None):
            raise ValueError("exactly one of settling_friction and relative_density is needed")
        if self.coarsening > 1 and self.thickness > 0:
            raise ValueError("coarsening: for discs only (thickness = 0)")
        if self.fine is not None and not self._reached_by(self.fine):
            raise ValueError(f"fine: must reach into the bed, got {self.fine}")
        return self

    def _reached_by(self, fine: FineRegion) -> bool:
        return fine.bottom < self.depth and fine.left < self.width and fine.right > 0


class Contact(Table):
    """Stiffness of contacts and how finely they are resolved in time."""

    law: Literal["linear", "hertz_mindlin"] = Field(
        default="linear", description="the latter for spheres only"
    )
    normal_stiffness: float = Field(
        default=0.0, ge=0, description="linear: N/m per metre of width; of spheres per metre of mean diameter"
    )
    tangential_stiffness_ratio: float = Field(
        default=0.5, gt=0, le=1, description="linear: tangential / normal stiffness"
    )
    young_modulus: float = Field(default=0.0, ge=0, description="hertz_mindlin: of the grains, Pa")
    poisson_ratio: float = Field(default=0.25, ge=0, lt=0.5, description="hertz_mindlin: of the grains")
    impact_speed: float = Field(
        default=1.0, gt=0, le=100, description="hertz_mindlin: greatest relative speed of collisions, m/s"
    )
    cohesion: float = Field(
        default=0.0,
        ge=0,
        description="force that parts two grains: N per metre of width; of spheres / reduced radius, N/m",
    )
    steps_per_contact: int = Field(ge=15, le=200, description="time steps in the shortest binary collision")

    @model_validator(mode="after")
    def _has_its_stiffness(self) -> Self:
        needed = {"linear": "normal_stiffness", "hertz_mindlin": "young_modulus"}[self.law]
        if getattr(self, needed) <= 0:
            raise ValueError(f"law = {self.law!r}: {needed} > 0 is needed")
        return self


class Timing(Table):
    """When pictures are taken, and how much faster than in the laboratory the grains are driven."""

    frame_rate: float = Field(gt=0, description="1/s, in the laboratory's time")
    frame_count: int = Field(ge=2, le=100_000)
    samples_per_frame: int = Field(
        default=1, ge=1, le=1000, description="records of force between two frames"
    )
    speed_up: float = Field(
        default=1.0, gt=0, le=100, description="simulated / laboratory speed (quasi-static)"
    )
    record_contacts: bool = Field(default=False, description="record the forces between grains at frames")


class _Titled(Table):
    """What every scene has."""

    schema_version: Literal[1]
    name: str = Field(pattern=r"^[A-Za-z0-9_\-]+$")
    description: str
    seed: int = Field(default=0, ge=0, lt=2**63)
    picture_seed: int | None = Field(
        default=None,
        ge=0,
        lt=2**63,
        description="of texture, noise and nuisances: other pictures of the same motion; default: seed",
    )
    quick: bool = False
    data_licence: str = Field(
        default="CC-BY-4.0",
        pattern=r"^[^\r\n]{1,200}$",
        description="of the footage, which is whoever renders it's to choose: an SPDX name, or words",
    )

    def to_dict(self) -> dict[str, Any]:
        """Every key with its value, defaults included; what is not given and has no value is left out."""
        return self.model_dump(mode="json", exclude_none=True)

    def to_toml(self) -> str:
        """The resolved scene as TOML; `load_scene` reads it back to an equal scene."""
        import tomli_w

        return tomli_w.dumps(self.to_dict())

    @property
    def seed_of_pictures(self) -> int:
        """What texture, noise and nuisances are drawn from."""
        return self.seed if self.picture_seed is None else self.picture_seed

    @property
    def hash(self) -> str:
        """SHA-256 over every value of the scene, hexadecimal."""
        return _digest(self.to_dict())

    @property
    def simulation_hash(self) -> str:
        """SHA-256 over what the motion depends on: the scene without its pictures, looks and labels."""
        told = {k: v for k, v in self.to_dict().items() if k not in _PICTURES_ALONE | _LABELS}
        told.get("soil", {}).pop("look", None)
        return _digest(told)


class _Scene(_Titled):
    """What every scene has that the camera photographs."""

    soil: Soil
    timing: Timing
    camera: Camera
    texture: Texture
    light: Light
    lens: Lens
    sensor: Sensor
    nuisance: Nuisance = Nuisance()


class SoilBinScene(_Scene):
    """An implement working in a glass-walled soil bin."""

    kind: Literal["soil_bin"]
    bed: Bed
    contact: Contact
    implement: Implement
    drive: Drive

    @model_validator(mode="after")
    def _fits(self) -> Self:
        least, greatest = self.program.reach_x((self.timing.frame_count - 1) / self.timing.frame_rate)
        reach = self.implement.shape.reach
        left, right = self.drive.start + least - reach, self.drive.start + greatest + reach
        if left < 0 or right > self.bed.width:
            raise ValueError(
                f"the implement must stay between the end walls: it sweeps x = {left:.3f} to {right:.3f} m "
                f"of bed.width = {self.bed.width} m"
            )
        if self.bed.depth < 5 * self.bed.grain_diameter:
            raise ValueError(
                f"bed.grain_diameter = {self.bed.grain_diameter} m is too coarse: "
                f"at most a fifth of bed.depth is allowed"
            )
        self._check_slab()
        return self

    def _check_slab(self) -> None:
        bed = self.bed
        if bed.thickness == 0:
            if self.contact.law == "hertz_mindlin":
                raise ValueError(
                    "contact.law = 'hertz_mindlin': for spheres only, bed.thickness > 0 is needed"
                )
        elif bed.thickness < 3 * bed.grain_diameter:
            raise ValueError(
                f"bed.thickness = {bed.thickness} m: at least three of bed.grain_diameter are needed, "
                "or 0 for discs"
            )
        elif bed.settling_friction is None:
            raise ValueError("bed.relative_density: for discs only (bed.thickness = 0)")
        elif self.timing.record_contacts:
            raise ValueError("timing.record_contacts = true: allowed for discs only (bed.thickness = 0)")

    @property
    def simulated_width(self) -> float:
        """Width of what is simulated, m: a slab's thickness; 1 for discs, all of which is per metre."""
        return self.bed.thickness or 1.0

    @model_validator(mode="after")
    def _rim_keeps_up(self) -> Self:
        if isinstance(self.implement, CompliantWheel):
            from synth.dem.contact_law import contact_time

            stiffness, smallest = (
                self.contact.normal_stiffness,
                self.bed.grain_diameter * (1 - self.bed.polydispersity),
            )
            # The bed's solid fraction is not known yet: no less than this.
            mass = self.soil.bulk_density / _LOOSEST * 0.25 * math.pi * smallest**2
            step = contact_time(mass, stiffness) / self.contact.steps_per_contact
            self.implement.check_time_step(step, contact_stiffness=stiffness, grain_diameter=smallest)
        return self

    @property
    def program(self) -> Program:
        """What the carriage does."""
        return self.drive.program(self.implement)


class PlateScene(_Scene):
    """A plate with a layer of soil, turned about a pin and seen from above."""

    kind: Literal["plate_rotation"]
    implement: Plate


class AnalyticScene(_Titled):
    """Soil that fills the picture and moves by a formula; no simulator, no camera model, an exact truth."""

    kind: Literal["analytic"]
    motion: Motion
    timing: AnalyticTiming
    camera: AnalyticCamera
    grains: GaussianGrains
    lens: AnalyticLens
    sensor: AnalyticSensor

    @model_validator(mode="after")
    def _stays_in_order(self) -> Self:
        if self.motion.folds_within(self.timing.frame_count - 1):
            raise ValueError(
                f"timing.frame_count = {self.timing.frame_count}: until then the motion strains the soil by "
                "0.8: fewer frames, a smaller amplitude or longer periods are needed"
            )
        return self


Scene = SoilBinScene | PlateScene
"""A scene that the camera photographs."""
AnyScene = Scene | AnalyticScene
_KINDS = {"soil_bin", "plate_rotation", "analytic"}
_KINDS |= {kind for union in (Implement, Drive, Motion) for kind in kinds_of(union)}
_SCENE: TypeAdapter[AnyScene] = TypeAdapter(Annotated[AnyScene, Field(discriminator="kind")])


def load_scene(name_or_path: str | Path, *, quick: bool = False, seed: int | None = None) -> AnyScene:
    """Read a scene file.

    Parameters
    ----------
    name_or_path : str or Path
        A shipped scene's name or a TOML file. A file with the key `base` has only what differs from the
        shipped scene named there, which may have a base, too.
    quick : bool
        Apply the file's `[quick]` table: a smaller and coarser version of the same scene.
    seed : int, optional
        Another realisation of bed, texture and noise.

    Raises
    ------
    SceneError
        With file, key, value and what is allowed.
    """
    path = _find(name_or_path)
    tables = _with_base(_read_toml(path), path)
    if str(tables.get("soil", "")).endswith(".toml"):
        tables["soil"] = str(path.parent / tables["soil"])  # beside the scene's file
    overrides = tables.pop("quick", None)
    if isinstance(overrides, bool):  # a resolved scene, which says what it was made with
        tables["quick"] = overrides
    elif overrides is not None:
        smaller = {**_merged(tables, overrides, path, "quick"), "quick": True}
        # faults of either version are told at once, whichever is asked for
        parse_scene(tables, source=str(path), folder=path.parent)
        parse_scene(smaller, source=f"{path}: with [quick]", folder=path.parent)
        tables = smaller if quick else tables
    if quick and not tables.get("quick"):
        raise SceneError(f"{path}: quick: this scene has no [quick] table")
    if seed is not None:
        tables["seed"] = seed
    return parse_scene(tables, source=str(path), folder=path.parent)


def parse_scene(tables: dict[str, Any], *, source: str = "scene", folder: str | Path = ".") -> AnyScene:
    """Check the tables of a scene; resolve its soil, and an STL to its outline.

    Parameters
    ----------
    source : str
        Stands in front of every complaint.
    folder : str or Path
        Where files that the scene names are.

    Raises
    ------
    SceneError
        With key, value and what is allowed.
    """
    soil = tables.get("soil")
    if isinstance(soil, str):
        tables = {**tables, "soil": load_soil(soil, source=source).soil}
    implement = tables.get("implement")
    if isinstance(implement, dict) and implement.get("kind") == "stl":
        tables = {**tables, "implement": _cut_stl(implement, source, Path(folder))}
    try:
        scene = _SCENE.validate_python(tables)
        return _with_fine_region(scene) if isinstance(scene, SoilBinScene) else scene
    except ValidationError as error:
        raise SceneError(_complaint(error, AnyScene, source)) from None


def changed_scene(scene: AnyScene, changes: Mapping[str, Any], *, source: str = "scene") -> AnyScene:
    """A scene with other values for some of its keys, checked as those of a file are.

    Parameters
    ----------
    changes : mapping
        Value by dotted key, `{"drive.slip": 0.3, "soil": "fillite"}`.
    source : str
        Stands in front of every complaint.

    Raises
    ------
    SceneError
        With key, value and what is allowed.
    """
    tables = scene.to_dict()
    nested: dict[str, Any] = {}
    for key, value in sorted(changes.items()):
        *path, name = key.split(".")
        inner = nested
        for part in path:
            inner = inner.setdefault(part, {})
            if not isinstance(inner, dict):
                raise SceneError(f"{source}: {key}: {part!r} is changed as a whole, too")
        inner[name] = value
    if isinstance(nested.get("soil"), str):
        del tables["soil"]  # its name stands for the whole table
    return parse_scene(_merged(tables, nested, Path(source), "scene"), source=source)


def _with_fine_region(scene: SoilBinScene) -> SoilBinScene:
    """The scene with the region of finest grains that its camera and its drive ask for."""
    if scene.bed.coarsening == 1 or scene.bed.fine is not None:
        return scene
    from synth.dem.grading import region_worked_and_seen

    fine = region_worked_and_seen(scene)
    return scene.model_copy(update={"bed": scene.bed.model_copy(update={"fine": fine})})


def _find(name_or_path: str | Path) -> Path:
    path = Path(name_or_path)
    if path.suffix == ".toml" or path.is_file():
        if not path.is_file():
            raise SceneError(f"{path}: no such file; shipped scenes: {', '.join(scene_names())}")
        return path
    shipped = scenes_folder() / f"{name_or_path}.toml"
    if str(name_or_path) not in scene_names() + study_scene_names():
        raise SceneError(
            f"scene {str(name_or_path)!r} is neither a file nor a shipped scene: {', '.join(scene_names())}"
        )
    return shipped


def _read_toml(path: Path) -> dict[str, Any]:
    try:
        return read_toml(path)
    except OSError as error:
        raise SceneError(f"{path}: {error.strerror}") from None
    except ValueError as error:
        raise SceneError(f"{path}: not TOML: {error}") from None


def _with_base(tables: dict[str, Any], path: Path) -> dict[str, Any]:
    """The tables of a file, laid over those of the shipped scene that it names as its `base`, and so on."""
    if "base" not in tables:
        return tables
    name = tables.pop("base")
    if name not in scene_names():
        raise SceneError(f"{path}: base = {name!r}: allowed are {', '.join(scene_names())}")
    shipped = scenes_folder() / f"{name}.toml"
    base = _with_base(_read_toml(shipped), shipped)
    for key, value in tables.items():
        if _of_another_kind(base.get(key), value):
            base.get("quick", {}).pop(key, None)
    return _merged(base, tables, path, "scene")


def _of_another_kind(old: Any, new: Any) -> bool:
    """Whether a table replaces another one, of whose keys none mean anything for it."""
    return (
        isinstance(old, dict) and isinstance(new, dict) and "kind" in new and new["kind"] != old.get("kind")
    )


def load_soil(name_or_path: str | Path, *, source: str = "soil") -> SoilFile:
    """Read a shipped soil by its name, or a soil's TOML file; `source` stands in front of every complaint.

    Raises
    ------
    SceneError
        With file, key, value and what is allowed.
    """
    path = soil_path(name_or_path, source=source)
    try:
        return SoilFile.model_validate(_read_toml(path))
    except ValidationError as error:
        raise SceneError(_complaint(error, SoilFile, str(path))) from None


def _cut_stl(table: dict[str, Any], source: str, folder: Path) -> dict[str, Any]:
    """The table of the outline that an STL's table stands for: a resolved scene needs no other file."""
    from synth.implements.stl import Stl, StlError

    try:
        return Stl.model_validate(table).outlined(folder)
    except ValidationError as error:
        raise SceneError(_complaint(error, Stl, source, within="implement")) from None
    except StlError as error:
        raise SceneError(f"{source}: implement.{error}") from None


def soil_path(name_or_path: str | Path, *, source: str = "soil") -> Path:
    """File of a shipped soil, or that which is given.

    Raises
    ------
    SceneError
        There is no such soil.
    """
    if Path(name_or_path).suffix == ".toml":
        return Path(name_or_path)
    if str(name_or_path) not in soil_names():
        allowed = f"a table, a TOML file or one of {', '.join(soil_names())}"
        raise SceneError(f"{source}: soil = {str(name_or_path)!r}: allowed is {allowed}")
    return scenes_folder() / "soils" / f"{name_or_path}.toml"


def _merged(tables: dict[str, Any], overrides: Any, path: Path, where: str) -> dict[str, Any]:
    if not isinstance(overrides, dict):
        raise SceneError(f"{path}: {where} = {overrides!r}: a table is needed")
    merged = {key: value for key, value in tables.items() if _RIVALS.get(key) not in overrides}
    for key, value in overrides.items():
        nested = isinstance(merged.get(key), dict) and not _of_another_kind(merged[key], value)
        merged[key] = _merged(merged[key], value, path, f"{where}.{key}") if nested else value
    return merged


def _complaint(error: ValidationError, tables: Any, source: str, *, within: str = "") -> str:
    """The first fault in one line: file, key, value, what is allowed."""
    faults = error.errors(include_url=False)
    # A misspelt key is told before the key that is missing because of it.
    fault = min(faults, key=lambda one: one["type"] != "extra_forbidden")
    kind, value = fault["type"], fault["input"]
    keys = [within] * bool(within) + [str(part) for part in fault["loc"] if part not in _KINDS]
    if kind.startswith("union_tag"):  # a table's `kind`, before any other key is looked at
        return f"{source}: {'.'.join([*keys, 'kind'])}{_kind_complaint(kind, fault)}"
    key = ".".join(keys) or "scene"
    if kind == "missing":
        return f"{source}: {key}: missing"
    shown = "" if isinstance(value, dict) else f" = {_shortened(repr(value))}"
    if kind == "extra_forbidden":
        return f"{source}: {key}{shown}: {unknown_key(tables, fault['loc'])}"
    return f"{source}: {key}{shown}: {fault['msg'].removeprefix('Value error, ')}"


def _kind_complaint(kind: str, fault: Any) -> str:
    if kind == "union_tag_not_found":
        return ": missing"
    context = fault["ctx"]
    more = ", 'stl'" if "'outline'" in context["expected_tags"] else ""
    return f" = {context['tag']!r}: allowed are {context['expected_tags']}{more}"


def _shortened(text: str) -> str:
    return text if len(text) <= _LONGEST_SHOWN else f"{text[:_LONGEST_SHOWN]}..."


def _digest(tables: dict[str, Any]) -> str:
    canonical = json.dumps(tables, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(canonical.encode()).hexdigest()
