"""What a sweep would take: how many, how long, how large; nothing is computed."""

from collections import Counter
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from synth.dataset.execution import Asked
from synth.dataset.folder import DataSetFolder
from synth.dataset.members import Member
from synth.dataset.stage_seconds import (
    STAGES,
    bed_seconds,
    grain_count,
    picture_seconds,
    simulation_seconds,
)
from synth.dataset.summary import Facts, read_facts, read_manifest
from synth.dataset.sweep import SPLITS

START_SECONDS = 9.0
"""Until a worker has loaded its libraries and kernels, all workers at once."""
PIXEL_BYTES = 11.0
"""On disk, of a picture with its truth."""
GRAIN_BYTES = 36.0
"""On disk, of a grain in a frame of a recording."""


@dataclass(frozen=True)
class Forecast:
    """What is to be made, and what for it.

    Attributes
    ----------
    member_count, made_count, impossible_count, repeated_count : int
        Members in all; of them there already; points that are no scene, and that repeat another one.
    reasons : list of str
        Why points are no scene; each once.
    simulation_count, bed_count, frame_count : int
        To be made: what is there already does not count.
    split_counts : dict of int
        All members.
    empty_splits : list of str
        Those that are to have a share, and get no member.
    core_seconds : dict of float
        By stage.
    workers : int
    seconds : float
        With so many workers, kept busy once they have started.
    bytes : int
    basis : str
        What times and sizes rest on.
    """

    member_count: int
    made_count: int
    impossible_count: int
    repeated_count: int
    reasons: list[str]
    simulation_count: int
    bed_count: int
    frame_count: int
    split_counts: dict[str, int]
    empty_splits: list[str]
    core_seconds: dict[str, float]
    workers: int
    seconds: float
    bytes: int
    basis: str

    def to_dict(self) -> dict[str, Any]:
        """JSON."""
        return {"schema_version": 1, **asdict(self)}


def forecast(sweep_file: str | Path, out: str | Path, *, workers: int | None = None) -> Forecast:
    """Look at a sweep, and at what is there of it; writes nothing.

    Times and sizes are those at stated rates, corrected by what members took that are there. Raises what
    `make_data_set` does of a sweep and a folder.
    """
    import os

    asked, folder = Asked.read(sweep_file), DataSetFolder(Path(out))
    read_manifest(folder)
    members = asked.membership.members
    made = {m.name: read_facts(folder, m.name) for m in members if folder.is_made(m.name)}
    missing = [member for member in members if member.name not in made]
    moves = {m.simulation: m for m in missing if not folder.recording(m.simulation).is_file()}
    beds = {m.bed: m for m in moves.values() if m.bed is not None}
    seconds = {
        "bed": sum(bed_seconds(one.scene) for one in beds.values()),
        "simulation": sum(simulation_seconds(one.scene) for one in moves.values()),
        "pictures": sum(picture_seconds(one.scene) for one in missing),
    }
    factors = {stage: _correction(stage, members, made) for stage in STAGES}
    seconds = {stage: value * factors[stage] for stage, value in seconds.items()}
    count = workers or len(os.sched_getaffinity(0))
    splits = Counter(member.split for member in members)
    return Forecast(
        member_count=len(members),
        made_count=len(made),
        impossible_count=len(asked.membership.impossible),
        repeated_count=asked.membership.repeated,
        reasons=sorted({one.reason for one in asked.membership.impossible}),
        simulation_count=len(moves),
        bed_count=len(beds),
        frame_count=sum(one.scene.timing.frame_count for one in missing),
        split_counts={split: splits[split] for split in SPLITS},
        empty_splits=asked.empty_splits,
        core_seconds=seconds,
        workers=count,
        seconds=sum(seconds.values()) / count + (START_SECONDS if missing else 0.0),
        bytes=round(sum(map(_bytes, missing)) + sum(map(_recording_bytes, moves.values()))),
        basis=f"{len(made)} members that are there" if made else "stated rates",
    )


def _bytes(member: Member) -> float:
    camera = member.scene.camera
    return PIXEL_BYTES * camera.width * camera.height * member.scene.timing.frame_count


def _recording_bytes(member: Member) -> float:
    return GRAIN_BYTES * grain_count(member.scene) * member.scene.timing.frame_count


def _correction(stage: str, members: tuple[Member, ...], made: dict[str, Facts]) -> float:
    """What a stage took / what it was foretold to take, of members that are there; 1 without one."""
    took = [(m, made[m.name]["seconds"].get(stage)) for m in members if m.name in made]
    known = [(STAGES[stage](member.scene), seconds) for member, seconds in took if seconds is not None]
    foretold = sum(pair[0] for pair in known)
    return sum(pair[1] for pair in known) / foretold if foretold > 0 else 1.0
