"""What a run folder says about itself: what made each file, and how to tell that it is whole."""

import hashlib
import json
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from synth.text_files import read_json

SCHEMA_VERSION = 1
MANIFEST_FILE = "manifest.json"


class RunFolderError(ValueError):
    """A folder that cannot be used as asked; the message is one line for the person who gave it."""


class _Record(BaseModel):
    model_config = ConfigDict(extra="forbid")


class Step(_Record):
    """One step of the chain as it was done."""

    key: str = Field(description="hash of all that its result depends on")
    seconds: float = Field(ge=0, description="wall time")
    files: list[str] = Field(description="what it wrote, relative to the run folder, sorted")
    facts: dict[str, Any] = Field(default_factory=dict, description="what later steps need to know")
    versions: dict[str, str] = Field(default_factory=dict, description="of the packages that made it")


class Manifest(_Record):
    """The content of `manifest.json`."""

    schema_version: Literal[1] = 1
    program: Literal["softbed"] = "softbed"
    scene: str = ""
    scene_hash: str = ""
    seed: int = 0
    quick: bool = False
    versions: dict[str, str] = Field(default_factory=dict)
    machine: dict[str, str | int] = Field(default_factory=dict)
    steps: dict[str, Step] = Field(default_factory=dict)
    files: dict[str, str] = Field(default_factory=dict, description="SHA-256 of every file, hexadecimal")

    @classmethod
    def read(cls, folder: Path) -> Self:
        """Read the manifest of a run folder.

        Raises
        ------
        RunFolderError
            There is none, it is damaged, or another version of this program wrote it.
        """
        path = folder / MANIFEST_FILE
        try:
            content = read_json(path)
        except FileNotFoundError:
            raise RunFolderError(f"{folder}: not a run folder: it holds no {MANIFEST_FILE}") from None
        except ValueError as error:
            raise RunFolderError(f"{path}: not a manifest: {error}") from None
        return cls._checked(content, path)

    @classmethod
    def _checked(cls, content: Any, path: Path) -> Self:
        version = content.get("schema_version") if isinstance(content, dict) else None
        if version != SCHEMA_VERSION:
            raise RunFolderError(f"{path}: schema_version = {version!r}: this program reads {SCHEMA_VERSION}")
        try:
            return cls.model_validate(content)
        except ValidationError as error:
            fault = error.errors(include_url=False)[0]
            key = ".".join(str(part) for part in fault["loc"])
            raise RunFolderError(f"{path}: not a manifest of this program: {key}: {fault['msg']}") from None

    def to_json(self) -> str:
        """Spell out the manifest as indented JSON."""
        return json.dumps(self.model_dump(mode="json"), indent=1) + "\n"


def file_digest(path: Path) -> str:
    """SHA-256 of a file's bytes, hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def key_of(**inputs: Any) -> str:
    """SHA-256 over named inputs (anything JSON can hold), hexadecimal: equal inputs, equal key."""
    canonical = json.dumps(inputs, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(canonical.encode()).hexdigest()
