"""A run folder: the names in it, and how its files come and stay whole."""

import contextlib
import fcntl
import os
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from validation.manifest import MANIFEST_FILE, Manifest, RunFolderError, Step, file_digest
from validation.versions import machine, package_versions

PARTIAL_PREFIX = ".partial-"
CHECKPOINT = ".checkpoint"


@dataclass
class Draft:
    """Where a step writes before its files get their names.

    Attributes
    ----------
    folder : Path
        An empty folder inside the run folder; paths below it mirror the run folder's.
    facts : dict
        What the step wants remembered in the manifest.
    """

    folder: Path
    facts: dict[str, Any] = field(default_factory=dict)


class RunFolder:
    """One folder with all that one run made.

    A step writes into a `Draft`, whose files get their final names by renaming when the step has succeeded:
    under a final name nothing is ever half-written. One process at a time works in a run folder.

    Attributes
    ----------
    path : Path
        The folder.
    manifest : Manifest
        What it says of itself, as last written.
    """

    def __init__(self, path: Path, manifest: Manifest) -> None:
        self.path = path
        self.manifest = manifest

    @classmethod
    @contextlib.contextmanager
    def create(cls, path: str | Path) -> Iterator[Self]:
        """Work in a run folder, made where there is none yet.

        Raises
        ------
        RunFolderError
            The path is a file, holds something else than a run, or another process works in it.
        """
        folder = Path(path)
        if folder.exists() and not folder.is_dir():
            raise RunFolderError(f"{folder}: is a file: a folder is needed")
        if not is_run_folder(folder):
            _refuse_foreign(folder)
        folder.mkdir(parents=True, exist_ok=True)
        with _sole_user(folder):
            _remove_leftovers(folder)
            run = cls(folder, Manifest.read(folder) if is_run_folder(folder) else Manifest())
            if not is_run_folder(folder):
                run._write_manifest()
            yield run

    @classmethod
    @contextlib.contextmanager
    def open(cls, path: str | Path) -> Iterator[Self]:
        """Work in a run folder that exists.

        Raises
        ------
        RunFolderError
            It does not, or another process works in it.
        """
        folder = Path(path)
        if not folder.is_dir():
            raise RunFolderError(f"{folder}: no such folder")
        Manifest.read(folder)
        with cls.create(folder) as run:
            yield run

    @property
    def scene(self) -> Path:
        """The resolved scene."""
        return self.path / "scene.toml"

    @property
    def recording(self) -> Path:
        """States of particles and implement."""
        return self.path / "recording.nc"

    @property
    def stopped_recording(self) -> Path:
        """States until a simulation had to stop; never beside a recording of the same scene."""
        return self.path / "recording-stopped.nc"

    @property
    def checkpoint(self) -> Path:
        """Where a killed simulation goes on from; gone once its recording is whole."""
        return self.path / CHECKPOINT

    @property
    def forces(self) -> Path:
        """Forces over time."""
        return self.path / "forces.csv"

    @property
    def footage(self) -> Path:
        """Pictures and truth."""
        return self.path / "footage"

    @property
    def vtk(self) -> Path:
        """Grains and implement for ParaView."""
        return self.path / "vtk"

    @property
    def scores(self) -> Path:
        """Scores of every method."""
        return self.path / "scores.json"

    @property
    def report(self) -> Path:
        """The page for a person."""
        return self.path / "report.html"

    @property
    def figures(self) -> Path:
        """Figures of a measurement without truth."""
        return self.path / "figures"

    def analysis(self, slug: str) -> Path:
        """Path of the soil flow one method measured."""
        return self.path / "analysis" / f"{slug}.nc"

    def kept_flow(self, slug: str) -> Path:
        """Where flow of a stopped analysis is kept; gone once its soil flow is whole."""
        return self.path / f".analysis-{slug}"

    def why_do(self, step: str, key: str) -> str | None:
        """Say why `step` must be done; None where its files are there, whole and of this key."""
        done = self.manifest.steps.get(step)
        if done is None:
            return "not done yet"
        if done.key != key:
            return "what it depends on has changed"
        for name in done.files:
            if not (self.path / name).is_file():
                return f"{name} is missing"
            if file_digest(self.path / name) != self.manifest.files.get(name):
                return f"{name} is damaged or was changed"
        return None

    @contextlib.contextmanager
    def writing(self, step: str, key: str) -> Iterator[Draft]:
        """Do a step: what is written into the draft replaces what the step wrote before, or leaves no trace.

        Parameters
        ----------
        step : str
            The step's name in the manifest.
        key : str
            Hash of all that the result depends on.
        """
        started = time.perf_counter()
        with self._draft() as folder:
            draft = Draft(folder)
            yield draft
            files = _files_below(folder)
            digests = {name: file_digest(folder / name) for name in files}
            self._publish(folder)
        seconds = time.perf_counter() - started
        self._forget_files_of(step)
        self.manifest.files.update(digests)
        self.manifest.steps[step] = Step(
            key=key, seconds=seconds, files=files, facts=draft.facts, versions=package_versions()
        )
        self._write_manifest()

    def put_aside(self, path: Path, write: Callable[[Path], None]) -> None:
        """Write a file that belongs to no step: whole under its name, or not at all."""
        with self._draft() as folder:
            write(folder / path.name)
            self._publish(folder)

    def label(self, *, scene: str, scene_hash: str, seed: int, quick: bool) -> None:
        """Say in the manifest which scene this run is of."""
        manifest = self.manifest
        manifest.scene, manifest.scene_hash, manifest.seed, manifest.quick = scene, scene_hash, seed, quick
        self._write_manifest()

    def _forget_files_of(self, step: str) -> None:
        for name in self.manifest.steps[step].files if step in self.manifest.steps else ():
            self.manifest.files.pop(name, None)

    def _write_manifest(self) -> None:
        self.manifest.versions, self.manifest.machine = package_versions(), machine()
        with self._draft() as folder:
            (folder / MANIFEST_FILE).write_text(self.manifest.to_json(), encoding="utf-8")
            self._publish(folder)

    @contextlib.contextmanager
    def _draft(self) -> Iterator[Path]:
        """Make a folder aside that is gone afterwards, whatever happens."""
        outer = Path(tempfile.mkdtemp(prefix=PARTIAL_PREFIX, dir=self.path))
        try:
            inner = outer / "new"
            inner.mkdir()  # unlike mkdtemp's, with the permissions the user's umask asks for
            yield inner
        finally:
            shutil.rmtree(outer, ignore_errors=True)

    def _publish(self, draft: Path) -> None:
        """Rename what lies in `draft`: whole folders, except `analysis`, which methods share."""
        for source in sorted(draft.iterdir()):
            if source.name == "analysis":
                (self.path / "analysis").mkdir(exist_ok=True)
                for file in sorted(source.iterdir()):
                    file.replace(self.path / "analysis" / file.name)
            elif source.is_dir():
                _replace_folder(source, self.path / source.name, aside=draft.parent / f"old-{source.name}")
            else:
                source.replace(self.path / source.name)


def is_run_folder(path: Path) -> bool:
    """Whether a folder says that it is one."""
    return (path / MANIFEST_FILE).is_file()


def _replace_folder(new: Path, final: Path, *, aside: Path) -> None:
    # A full folder cannot be renamed over: for an instant the name is free, never half-filled.
    if final.exists():
        final.rename(aside)
    new.rename(final)


def _refuse_foreign(folder: Path) -> None:
    names = [entry.name for entry in _entries(folder)]
    strangers = [name for name in names if not name.startswith(PARTIAL_PREFIX) and name != CHECKPOINT]
    if strangers:
        raise RunFolderError(
            f"{folder}: neither empty nor a run folder (it holds {min(strangers)!r} and no {MANIFEST_FILE}): "
            "nothing is overwritten, choose another"
        )


def _entries(folder: Path) -> list[Path]:
    return list(folder.iterdir()) if folder.exists() else []


def _remove_leftovers(folder: Path) -> None:
    """Remove what a killed run was writing; only the folder's sole user may do this."""
    for entry in _entries(folder):
        if entry.name.startswith(PARTIAL_PREFIX) and entry.is_dir() and not entry.is_symlink():
            shutil.rmtree(entry)


def _files_below(folder: Path) -> list[str]:
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


@contextlib.contextmanager
def _sole_user(folder: Path) -> Iterator[None]:
    """Hold a lock on the folder itself: it leaves no file behind and ends with the process."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise RunFolderError(f"{folder}: another softbed works in it: wait for it to end") from None
        yield
    finally:
        os.close(handle)
