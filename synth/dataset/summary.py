"""What is said of a data set as a whole: manifest, members, failures, checksums; written anew each time."""

import csv
import hashlib
import io
import json
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from synth.checksums import CHECKSUM_FILE
from synth.dataset.folder import (
    FACTS_FILE,
    FAILURES_FILE,
    MANIFEST_FILE,
    MEMBERS_FILE,
    DataSetError,
    DataSetFolder,
)
from synth.dataset.members import Failure, Membership
from synth.dataset.sweep import SPLITS, Sweep
from synth.dataset.versions import all_versions
from synth.text_files import read_json

if TYPE_CHECKING:
    from synth.scene import AnyScene

SCHEMA_VERSION = 1
"""The major version of a data set's form: raised when older programs could not read it any more."""
KIND = "softbed data set"
MADE, FAILED, MISSING = "made", "failed", "missing"
Facts = dict[str, Any]


@dataclass(frozen=True)
class Told:
    """What a summary is of.

    Attributes
    ----------
    failures : dict of Failure
        By member.
    """

    sweep: Sweep
    base: "AnyScene"
    membership: Membership
    failures: dict[str, Failure] = field(default_factory=dict)


def write_summary(folder: DataSetFolder, told: Told) -> dict[str, Any]:
    """Write all of it; the manifest is returned."""
    from synth.dataset.card import write_card

    made = [member.name for member in told.membership.members if folder.is_made(member.name)]
    facts = {name: read_facts(folder, name) for name in made}
    manifest = _manifest(told, facts)
    folder.write(MANIFEST_FILE, json.dumps(manifest, indent=1) + "\n")
    folder.write(MEMBERS_FILE, _members_table(told, facts))
    folder.write(FAILURES_FILE, _failures_table(told))
    write_card(folder, told, facts, manifest)
    folder.write(CHECKSUM_FILE, _checksums(folder, made))
    return manifest


def read_facts(folder: DataSetFolder, name: str) -> Facts:
    """What is known of a member that is made: that of `sequence_facts`, and how it was made.

    Raises
    ------
    DataSetError
        It is damaged.
    """
    path = folder.sequence(name) / FACTS_FILE
    try:
        facts = read_json(path)
        wanted = {"digest", "recording_digest", "frame_count", "bytes", "seconds"}
        if not isinstance(facts, dict) or wanted - set(facts):
            raise ValueError(f"{', '.join(sorted(wanted))} are needed")
    except ValueError as error:
        raise DataSetError(
            f"{path}: not what is known of a sequence: {error}: remove its folder, and `softbed sweep` makes "
            "it again"
        ) from None
    return facts


def read_manifest(folder: DataSetFolder) -> dict[str, Any] | None:
    """What the manifest says; None without one.

    Raises
    ------
    DataSetError
        It is none of a data set, or one of another schema version.
    """
    path = folder.path / MANIFEST_FILE
    if not path.is_file():
        return None
    try:
        manifest = read_json(path)
    except ValueError as error:
        raise DataSetError(f"{path}: not a manifest: {error}") from None
    if not isinstance(manifest, dict) or manifest.get("kind") != KIND:
        raise DataSetError(f"{folder.path}: not a data set: its {MANIFEST_FILE} is another's")
    version = manifest.get("schema_version")
    versions = manifest.get("versions")
    if version != SCHEMA_VERSION:
        known = versions if isinstance(versions, dict) else {}
        made_by = known.get("softbed", "an unknown version")
        raise DataSetError(
            f"{path}: schema_version = {version!r}: this program reads {SCHEMA_VERSION}: use softbed "
            f"{made_by}, which made it, or make it anew with `softbed sweep {folder.path}/sweep.toml OUT`"
        )
    if not isinstance(versions, dict) or not isinstance(manifest.get("digest"), str):
        raise DataSetError(
            f"{path}: damaged: versions or digest missing: remove it, and `softbed sweep` writes it anew"
        )
    return manifest


def data_set_digest(facts: dict[str, Facts]) -> str:
    """SHA-256 over the names and the values of all sequences and recordings, by name."""
    lines = (f"{name} {facts[name]['digest']} {facts[name]['recording_digest']}\n" for name in sorted(facts))
    return hashlib.sha256("".join(lines).encode()).hexdigest()


def _manifest(told: Told, facts: dict[str, Facts]) -> dict[str, Any]:
    members = told.membership.members
    split_of = {member.name: member.split for member in members}
    counts = Counter(split_of[name] for name in facts)
    return {
        "schema_version": SCHEMA_VERSION,
        "kind": KIND,
        "name": told.sweep.name,
        "seed": told.sweep.seed,
        "digest": data_set_digest(facts),
        "complete": len(facts) == len(members),
        "member_count": len(members),
        "made_count": len(facts),
        "failed_count": len(told.failures) + len(told.membership.impossible),
        "split_counts": {split: counts[split] for split in SPLITS},
        "simulation_count": len({member.simulation for member in members}),
        "bed_count": len({member.bed for member in members if member.bed is not None}),
        "pair_count": sum(one["frame_count"] - 1 for one in facts.values()),
        "bytes": sum(one["bytes"] for one in facts.values()),
        "versions": all_versions(),
    }


def _members_table(told: Told, facts: dict[str, Facts]) -> str:
    keys = list(told.sweep.vary)
    header = ["name", "split", *keys, "simulation", "status", "frames", "seconds", "bytes"]
    rows = []
    for member in told.membership.members:
        made = facts.get(member.name)
        status = MADE if made else FAILED if member.name in told.failures else MISSING
        known = (
            [made["frame_count"], round(made["seconds"]["pictures"], 2), made["bytes"]] if made else [""] * 3
        )
        values = _spelt(member.values[key] for key in keys)
        rows.append([member.name, member.split, *values, member.simulation, status, *known])
    return _table(header, rows)


def _failures_table(told: Told) -> str:
    keys = list(told.sweep.vary)
    rows = [
        ["", *_spelt(one.values[key] for key in keys), "scene", one.reason]
        for one in told.membership.impossible
    ]
    for member in told.membership.members:
        if (failure := told.failures.get(member.name)) is not None:
            values = _spelt(member.values[key] for key in keys)
            rows.append([member.name, *values, failure.stage, failure.reason])
    return _table(["name", *keys, "stage", "reason"], rows)


def _spelt(values: Iterable[Any]) -> list[Any]:
    return [json.dumps(value) if isinstance(value, list | dict | bool) else value for value in values]


def _table(header: list[str], rows: Iterable[list[Any]]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return text.getvalue()


def _checksums(folder: DataSetFolder, made: list[str]) -> str:
    """Lines of `SHA256SUMS`; of sequences their own, of a recording that was listed before that of then."""
    from synth.checksums import file_digest, read_checksums

    former = read_checksums(folder.path) if (folder.path / CHECKSUM_FILE).is_file() else {}
    found: dict[str, str] = {}
    for name in made:
        place = f"sequences/{name}"
        found |= {f"{place}/{file}": digest for file, digest in read_checksums(folder.path / place).items()}
        found[f"{place}/{CHECKSUM_FILE}"] = file_digest(folder.path / place / CHECKSUM_FILE)
    for path in (folder.path / "recordings").glob("*.nc"):
        name = f"recordings/{path.name}"
        found[name] = former.get(name) or file_digest(path)
    for path in folder.path.iterdir():
        if path.is_file() and path.name != CHECKSUM_FILE and not path.name.startswith("."):
            found[path.name] = file_digest(path)
    return "".join(f"{digest}  {name}\n" for name, digest in sorted(found.items()))
