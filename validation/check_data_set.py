"""Whether a data set is whole: hashes of every file, then what its tables and its sequences say."""

import csv
from collections.abc import Callable, Iterator
from pathlib import Path

from synth.text_files import read_json
from validation.check import Fault, Findings, footage_faults, strangers, without, wrong_hashes
from validation.manifest import MANIFEST_FILE


def is_data_set(folder: Path) -> bool:
    """Whether a folder says that it is one."""
    from synth.dataset.summary import KIND

    try:
        manifest = read_json(folder / MANIFEST_FILE)
    except (OSError, ValueError):
        return False
    return isinstance(manifest, dict) and manifest.get("kind") == KIND


def check_data_set(folder: Path, progress: Callable[[int, int], None] | None) -> Findings:
    """Check a data set; nothing is written."""
    from synth.checksums import CHECKSUM_FILE, read_checksums
    from synth.dataset import DataSetError, load_data_set

    faults, listed = [], {}
    try:
        listed = read_checksums(folder)
    except (OSError, ValueError) as error:
        faults.append(Fault(CHECKSUM_FILE, without(error, folder)))
    damaged = dict(wrong_hashes(folder, listed, progress))
    faults += [Fault(name, fault) for name, fault in damaged.items()]
    try:
        data = load_data_set(folder)
    except DataSetError as error:
        faults.append(Fault(MANIFEST_FILE, without(error, folder)))
    else:
        for sequence in data.sequences:
            name = f"sequences/{sequence.name}"
            if not any(one.startswith(name) for one in damaged):
                faults += [Fault(name, fault) for fault in _sequence_faults(sequence.folder, sequence.name)]
        if not damaged:
            faults += _digest_faults(folder)
    remarks = [f"{name}: not of this data set" for name in strangers(folder, {*listed, CHECKSUM_FILE})]
    remarks += _not_made(folder)
    if any(fault.file.startswith(("sequences/", "recordings/")) for fault in faults):
        remarks.append(
            "remove what is damaged, a whole folder of a sequence, and `softbed sweep` makes it again"
        )
    return Findings(folder, "data set", len(listed), tuple(faults), tuple(remarks))


def _sequence_faults(folder: Path, name: str) -> Iterator[str]:
    from synth import load_scene

    try:
        if not load_scene(folder / "scene.toml").hash.startswith(name):
            yield "scene.toml: not the scene that the folder is named after"
    except ValueError as error:
        yield without(error, folder)
    yield from footage_faults(folder)


def _digest_faults(folder: Path) -> list[Fault]:
    """Whether the manifest's hash is that of the values that its sequences say they have."""
    from synth.dataset.folder import DataSetError, DataSetFolder
    from synth.dataset.summary import data_set_digest, read_facts, read_manifest

    place = DataSetFolder(folder)
    made = sorted(path.name for path in (folder / "sequences").glob("*"))
    try:
        manifest, facts = read_manifest(place), {name: read_facts(place, name) for name in made}
    except DataSetError as error:
        return [Fault("sequences", without(error, folder))]
    if manifest is None or manifest["digest"] == data_set_digest(facts):
        return []
    return [Fault(MANIFEST_FILE, "digest: not that of the sequences that are there")]


def _not_made(folder: Path) -> list[str]:
    """What the data set itself says is missing."""
    path = folder / "failures.csv"
    if not path.is_file():
        return []
    try:
        with path.open(newline="", encoding="utf-8") as file:
            return [
                f"not made: {row['name'] or 'a point'}: {row['stage']}: {row['reason']}"
                for row in csv.DictReader(file)
            ]
    except (KeyError, ValueError, csv.Error) as error:
        return [f"failures.csv: not a table of failures: {error}"]
