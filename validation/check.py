"""Whether a run folder or a footage folder is whole: hashes first, then what the files say."""

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from synth.disk import is_inside
from synth.text_files import read_json, read_toml
from validation.manifest import MANIFEST_FILE, Manifest, RunFolderError, file_digest
from validation.material import SEQUENCE_FILE, TRUTH_FILE

SCHEMA_VERSION = 1


@dataclass(frozen=True)
class Fault:
    """One thing that is wrong.

    Attributes
    ----------
    file : str
        Path within the folder.
    fault : str
        What is wrong with it.
    """

    file: str
    fault: str


@dataclass(frozen=True)
class Findings:
    """What a check found.

    Attributes
    ----------
    folder : Path
    kind : str
        `run folder`, `footage folder` or `data set`.
    file_count : int
        Files whose content was compared with a hash.
    faults : tuple of Fault
    remarks : tuple of str
        What could not be checked, or does not belong, in words.
    """

    folder: Path
    kind: str
    file_count: int
    faults: tuple[Fault, ...]
    remarks: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """As `--json` gives it."""
        return {
            "schema_version": SCHEMA_VERSION,
            "folder": str(self.folder),
            "kind": self.kind,
            "passed": not self.faults,
            "file_count": self.file_count,
            "faults": [{"file": fault.file, "fault": fault.fault} for fault in self.faults],
            "remarks": list(self.remarks),
        }

    def __str__(self) -> str:
        lines = [f"{fault.file}: {fault.fault}" for fault in self.faults] + list(self.remarks)
        count = len(self.faults)
        verdict = f"{count} {'fault' if count == 1 else 'faults'}" if count else "whole"
        return "\n".join([*lines, f"{self.folder}: {self.kind}, {self.file_count} files: {verdict}"])


def check_folder(folder: Path, *, progress: Callable[[int, int], None] | None = None) -> Findings:
    """Check a run folder, a footage folder or a data set; nothing is written.

    Parameters
    ----------
    folder : Path
    progress : callable, optional
        Called with the files hashed and the files in all.

    Raises
    ------
    RunFolderError
        It is none of these.
    """
    from validation.check_data_set import check_data_set, is_data_set

    if is_data_set(folder):
        return check_data_set(folder, progress)
    if (folder / MANIFEST_FILE).is_file():
        return _check_run(folder, progress)
    if (folder / SEQUENCE_FILE).is_file() or (folder / TRUTH_FILE).is_file():
        return _check_footage_folder(folder, progress)
    run, footage = f"{MANIFEST_FILE} (a run folder or a data set)", f"{SEQUENCE_FILE} (footage)"
    if not folder.is_dir():
        raise RunFolderError(f"{folder}: no such folder: needed is one with {run} or {footage}")
    raise RunFolderError(f"{folder}: holds neither {run} nor {footage}")


def _check_run(folder: Path, progress: Callable[[int, int], None] | None) -> Findings:
    try:
        manifest = Manifest.read(folder)
    except RunFolderError as error:
        return Findings(folder, "run folder", 0, (Fault(MANIFEST_FILE, without(error, folder)),), ())
    damaged = dict(wrong_hashes(folder, manifest.files, progress))
    faults = [Fault(name, fault) for name, fault in damaged.items()]
    for step, record in manifest.steps.items():
        unlisted = [name for name in record.files if name not in manifest.files]
        faults += [Fault(name, f"written by {step!r}, but without a hash") for name in unlisted]
    # A file that is known to be damaged needs no second complaint.
    for name, check in _contents(folder, manifest):
        if name not in damaged and (folder / name).exists():
            faults += [Fault(name, fault) for fault in check(folder / name)]
    remarks = [f"{name}: not of this run" for name in strangers(folder, {*manifest.files, MANIFEST_FILE})]
    return Findings(folder, "run folder", len(manifest.files), tuple(faults), tuple(remarks))


def _check_footage_folder(folder: Path, progress: Callable[[int, int], None] | None) -> Findings:
    from synth.checksums import CHECKSUM_FILE, read_checksums

    faults, remarks, listed = [], [], {}
    if (folder / CHECKSUM_FILE).is_file():
        try:
            listed = read_checksums(folder)
        except ValueError as error:
            faults.append(Fault(CHECKSUM_FILE, without(error, folder)))
        remarks += [f"{name}: not of this footage" for name in strangers(folder, {*listed, CHECKSUM_FILE})]
    else:
        remarks.append(f"no {CHECKSUM_FILE}: whether a value was edited cannot be told")
    damaged = dict(wrong_hashes(folder, listed, progress))
    faults += [Fault(name, fault) for name, fault in damaged.items()]
    if not damaged:
        faults += [Fault(".", fault) for fault in footage_faults(folder)]
    return Findings(folder, "footage folder", len(listed), tuple(faults), tuple(remarks))


def wrong_hashes(
    folder: Path, digests: dict[str, str], progress: Callable[[int, int], None] | None
) -> Iterator[tuple[str, str]]:
    """Files that are not what their SHA-256 says, and what is wrong with them."""
    for done, (name, digest) in enumerate(sorted(digests.items()), start=1):
        path = folder / name
        if not is_inside(name):
            yield name, "not inside the folder: not looked at"
        elif not path.is_file():
            yield name, "missing"
        elif path.stat().st_size == 0:
            yield name, "empty"
        elif file_digest(path) != digest:
            unreadable = _why_unreadable(path)
            yield name, f"damaged: {unreadable}" if unreadable else "edited: other content than was written"
        if progress is not None:
            progress(done, len(digests))


def _why_unreadable(path: Path) -> str | None:
    """Say why a file cannot be read as what its name says; None where it can, or where nobody knows."""
    try:
        if path.suffix == ".nc":
            import h5netcdf

            with h5netcdf.File(path, "r") as file:
                for variable in file.variables.values():
                    variable[...]
        elif path.suffix == ".png":
            from PIL import Image

            with Image.open(path) as picture:
                picture.load()
        elif path.suffix == ".json":
            read_json(path)
        elif path.suffix == ".toml":
            read_toml(path)
    except (OSError, ValueError, KeyError, RuntimeError, SyntaxError) as error:
        return f"not readable ({path.stat().st_size} bytes; cut short?): {without(error, path)}"
    return None


def _contents(folder: Path, manifest: Manifest) -> Iterator[tuple[str, Callable[[Path], list[str]]]]:
    """What to look into: path within the run folder, and the check of what it says."""
    yield "scene.toml", lambda path: _scene_faults(path, manifest)
    yield "recording.nc", _recording_faults
    yield "footage", footage_faults
    for path in sorted((folder / "analysis").glob("*.nc")):
        yield f"analysis/{path.name}", _analysis_faults
    yield "scores.json", _scores_faults


def _scene_faults(path: Path, manifest: Manifest) -> list[str]:
    from synth import load_scene

    try:
        scene = load_scene(path)
    except ValueError as error:
        return [without(error, path)]
    return [] if scene.hash == manifest.scene_hash else [f"not the scene of {MANIFEST_FILE}: another hash"]


def _recording_faults(path: Path) -> list[str]:
    from synth import Recording
    from synth.recording import VARIABLES

    try:
        data = Recording.read(path).data
    except (ValueError, OSError) as error:
        return [without(error, path)]
    return [f"variable {name} is missing" for name in VARIABLES if name not in data]


def footage_faults(folder: Path) -> list[str]:
    """Open footage and read every picture and every pair's truth."""
    from synth import Footage

    faults = []
    try:
        with Footage.open(folder) as footage:
            faults += [f"truth.nc: {fault}" for fault in _truth_faults(footage)]
            for frame in range(1, footage.frame_count):
                footage.picture(frame)
            for pair in range(footage.pair_count):
                footage.truth(pair)
    except (ValueError, OSError) as error:
        faults.append(without(error, folder))
    return faults


def _truth_faults(footage: Any) -> Iterator[str]:
    from synth.truth import VARIABLES

    for name, (dtype, unit, _) in VARIABLES.items():
        variable = footage.variables[name]
        for what, has, must in (
            ("dimensions", variable.dims, ("pair", "y", "x")),
            ("type", variable.dtype.name, dtype),
            ("units", variable.attrs.get("units"), unit),
        ):
            if has != must:
                yield f"variable {name}: {what} {has}: must be {must}"


def _analysis_faults(path: Path) -> list[str]:
    import soft
    from soft.soilflow_values import wrong_values

    try:
        with soft.read_soil_flow(path) as flow:
            return list(wrong_values(flow))
    except ValueError as error:
        return [without(error, path)]


def _scores_faults(path: Path) -> list[str]:
    from validation.scoring.score import Scores

    try:
        Scores.read(path)
    except (ValueError, json.JSONDecodeError) as error:
        return [without(error, path)]
    return []


def strangers(folder: Path, known: set[str]) -> list[str]:
    """Files that nothing lists; what a run keeps aside (names with a leading dot) does not count."""
    found = (path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())
    return sorted(name for name in found if name not in known and not name.startswith("."))


def without(error: Exception, path: Path) -> str:
    """The complaint in one line, without the path that stands before it anyway."""
    return " ".join(str(error).removeprefix(f"{path}: ").split())
