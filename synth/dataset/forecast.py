"""What a sweep would take: how many, how long, how large; nothing is computed."""

import functools
import math
from collections import Counter
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from synth.analytic.settings import AnalyticCamera
from synth.dataset.execution import Asked
from synth.dataset.folder import DataSetFolder
from synth.dataset.members import Member
from synth.dataset.summary import Facts, read_facts, read_manifest
from synth.dataset.sweep import SPLITS
from synth.scene import AnyScene, Bed, SoilBinScene

if TYPE_CHECKING:
    from synth.dem.contact_law import Law

STEP_SECONDS, DISC_SECONDS, SPHERE_SECONDS = 4.1e-5, 4.0e-8, 1.7e-7
"""Of a core: for a time step, and for each grain in it."""
FALL, REST = 0.53, 0.05
"""Simulated time in which a bed settles: falling and coming to rest in soft contacts, s / sqrt(m of depth);
and coming to rest in the scene's own, s."""
SEQUENCE_SECONDS, PIXEL_SECONDS, SAMPLE_SECONDS = 1.4, 9.3e-7, 1.0e-8
"""Of a core: for a sequence's texture, for each pixel of a picture with its truth, written and read back, and
for each of its samples."""
START_SECONDS = 9.0
"""Until a worker has loaded its libraries and kernels, all workers at once."""
PIXEL_BYTES = 11.0
"""On disk, of a picture with its truth."""
GRAIN_BYTES = 36.0
"""On disk, of a grain in a frame of a recording."""
_KEPT = 0.82
"""Grains of a settled bed / dropped ones."""
_STAGES = ("bed", "simulation", "pictures")


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
    factors = {stage: _correction(stage, members, made) for stage in _STAGES}
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


def bed_seconds(scene: AnyScene) -> float:
    """To settle a scene's bed, s of a core."""
    return _seconds(scene, bed_step_count(scene))


def simulation_seconds(scene: AnyScene) -> float:
    """To simulate a scene once its bed is settled, s of a core."""
    return _seconds(scene, step_count(scene))


def picture_seconds(scene: AnyScene) -> float:
    """To take a scene's pictures and read them back, s of a core."""
    camera = scene.camera
    pixels = camera.width * camera.height * scene.timing.frame_count
    if isinstance(camera, AnalyticCamera):
        return pixels * PIXEL_SECONDS
    return SEQUENCE_SECONDS + pixels * (PIXEL_SECONDS + camera.supersampling**2 * SAMPLE_SECONDS)


def grain_count(scene: AnyScene) -> float:
    """Grains of a scene's bed, about."""
    if not isinstance(scene, SoilBinScene):
        return 0
    layers = max(scene.bed.thickness / scene.bed.grain_diameter, 1)
    return _KEPT * layers * _dropped(scene.bed)


def step_count(scene: AnyScene) -> float:
    """Time steps of a simulation, about."""
    if not isinstance(scene, SoilBinScene):
        return 0
    from synth.dem.bed import contact_law
    from synth.dem.log import Schedule

    schedule = Schedule.of(scene, _time_step(scene, contact_law(scene)))
    return schedule.total * schedule.steps


def bed_step_count(scene: AnyScene) -> float:
    """Time steps in which a scene's bed settles, about."""
    if not isinstance(scene, SoilBinScene):
        return 0
    from synth.dem.bed import bin_of, contact_law
    from synth.dem.contact_law import ContactLaw

    law = contact_law(scene)
    own = _time_step(scene, law)
    soft = own
    if isinstance(law, ContactLaw):
        box = bin_of(scene.bed, scene.contact.steps_per_contact)
        soft = _time_step(scene, box.soft_law(law, scene.soil.bulk_density))
    return FALL * math.sqrt(scene.bed.depth) / soft + REST / own


def _seconds(scene: AnyScene, steps: float) -> float:
    """Of a core, for so many time steps of a scene's grains."""
    spheres = isinstance(scene, SoilBinScene) and scene.bed.thickness > 0
    return steps * (STEP_SECONDS + grain_count(scene) * (SPHERE_SECONDS if spheres else DISC_SECONDS))


def _time_step(scene: SoilBinScene, law: "Law") -> float:
    """Of grains that touch by a law, s: a share of the shortest collision of the smallest ones."""
    from synth.dem.contact_law import HertzMindlinLaw, contact_time, hertz_time

    bed = scene.bed
    radius = 0.5 * bed.grain_diameter * (1 - bed.polydispersity)
    volume = 4 / 3 * math.pi * radius**3 if bed.thickness else math.pi * radius**2
    mass = scene.soil.bulk_density / _KEPT * volume
    if isinstance(law, HertzMindlinLaw):
        shortest = float(hertz_time(mass / 2, radius / 2, law.effective_modulus, law.impact_speed))
    else:
        shortest = contact_time(mass, law.normal_stiffness)
    return shortest / scene.contact.steps_per_contact


@functools.lru_cache(maxsize=64)
def _dropped(bed: Bed) -> int:
    """Grains that a bed is made of, before it is levelled."""
    import numpy as np

    from synth.dem.bed import bin_of

    any_steps = 20  # of no consequence before grains move
    return bin_of(bed, any_steps).drop(np.random.default_rng(0), 1.0).count


def _bytes(member: Member) -> float:
    camera = member.scene.camera
    return PIXEL_BYTES * camera.width * camera.height * member.scene.timing.frame_count


def _recording_bytes(member: Member) -> float:
    return GRAIN_BYTES * grain_count(member.scene) * member.scene.timing.frame_count


def _correction(stage: str, members: tuple[Member, ...], made: dict[str, Facts]) -> float:
    """What a stage took / what it was foretold to take, of members that are there; 1 without one."""
    foretell = {"bed": bed_seconds, "simulation": simulation_seconds, "pictures": picture_seconds}[stage]
    took = [(m, made[m.name]["seconds"].get(stage)) for m in members if m.name in made]
    known = [(foretell(member.scene), seconds) for member, seconds in took if seconds is not None]
    foretold = sum(pair[0] for pair in known)
    return sum(pair[1] for pair in known) / foretold if foretold > 0 else 1.0
