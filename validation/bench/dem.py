"""The grain solver against LAMMPS: the same settled bed, contact law, time step and number of steps."""

import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING

import numpy as np

from validation.bench.lammps import Lammps
from validation.bench.rows import BenchRow, PeerError
from validation.versions import package_version

if TYPE_CHECKING:
    from synth.dem.bed import Bed
    from synth.scene import SoilBinScene

GRAIN_COUNTS = (20_000, 50_000)
_ASPECT = 3.0
"""Width / depth of the bed."""
_SLOPE = np.deg2rad(35.0)
"""Gravity leans by this: the bed's surface flows, so that neighbours have to be listed now and then."""
_METRIC = "particle-steps"
_UNIT = "1/s"


@dataclass(frozen=True)
class Work:
    """One case: a bed and how long it is advanced."""

    name: str
    scene: "SoilBinScene"
    bed: "Bed"
    time_step: float
    steps: int
    warm_up: int

    @property
    def gravity(self) -> tuple[float, float]:
        """Along x and z, m/s2."""
        gravity = self.scene.bed.gravity
        return gravity * float(np.sin(_SLOPE)), -gravity * float(np.cos(_SLOPE))

    def rate(self, seconds: float) -> float:
        """Particle-steps a second."""
        return self.bed.grains.count * self.steps / seconds


def bench_dem(
    *,
    grain_counts: Sequence[int] = GRAIN_COUNTS,
    repeats: int = 5,
    steps: int = 2000,
    threads: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> list[BenchRow]:
    """Particle-steps a second, ours and LAMMPS's in turn, their ratio, and whether bytes depend on threads.

    Parameters
    ----------
    grain_counts : sequence of int
        About how many grains each bed has.
    repeats : int
        Of every measurement; rows give the median.
    steps : int
        Time steps a measurement.
    threads : int, optional
        Ours, and LAMMPS's ranks. Default: every core.
    """
    from synth.devices import start_taichi

    workers = threads or os.cpu_count() or 1
    start_taichi(threads=workers)
    rows: list[BenchRow] = []
    total = len(grain_counts) * (repeats + 1)
    for case, count in enumerate(grain_counts):
        work = _work(count, steps)
        if progress is not None:
            progress(case * (repeats + 1) + 1, total)
        tick = _ticker(progress, case * (repeats + 1) + 1, total)
        rows += _measured(work, repeats, workers, tick)
    rows.append(_same_bytes(grain_counts[0]))
    return rows


def _ticker(progress: Callable[[int, int], None] | None, start: int, total: int) -> Callable[[int], None]:
    return lambda done: progress(start + done, total) if progress is not None else None


def _work(grain_count: int, steps: int) -> Work:
    from synth.dem.bed import contact_law, settled_bed
    from synth.dem.contact_law import time_step_of

    scene = bed_scene(grain_count)
    bed = settled_bed(scene)
    step = time_step_of(bed.grains, contact_law(scene), scene.contact.steps_per_contact)
    return Work(f"bed of {bed.grains.count} discs", scene, bed, step, steps, warm_up=200)


def bed_scene(grain_count: int) -> "SoilBinScene":
    """The shipped `rolling_wheel` with a bed of about so many grains, of its own size and contact law."""
    from synth.scene import SoilBinScene, load_scene, parse_scene

    shipped = load_scene("rolling_wheel")
    assert isinstance(shipped, SoilBinScene)
    tables = shipped.to_dict()
    area = grain_count * np.pi / 4 * shipped.bed.grain_diameter**2 / 0.8
    depth = float(np.sqrt(area / _ASPECT))
    tables["bed"] |= {"width": _ASPECT * depth, "depth": depth, "coarsening": 1.0}
    tables["bed"].pop("fine", None)
    # The wheel is not used; it only has to fit.
    tables["implement"] |= {"radius": depth / 4}
    tables["drive"] |= {"start": depth / 2, "run_in": 0.0}
    tables["timing"] |= {"frame_count": 2}
    scene = parse_scene(tables)
    assert isinstance(scene, SoilBinScene)
    return scene


def _measured(work: Work, repeats: int, workers: int, tick: Callable[[int], None]) -> list[BenchRow]:
    """Ours and LAMMPS's in turn, so that a machine that drifts treats both alike."""
    peer: Lammps | None = None
    reason = ""
    try:
        peer = Lammps.find()
    except PeerError as missing:
        reason = str(missing)
    ours: list[float] = []
    theirs: list[float] = []
    for repeat in range(repeats):
        ours.append(work.rate(_own_seconds(work)))
        if peer is not None:
            try:
                theirs.append(work.rate(_peer_seconds(work, peer, workers)))
            except PeerError as failed:
                peer, reason = None, str(failed)
        tick(repeat + 1)
    version = package_version("softbed")
    rows = [_row(work, "softbed", version, True, _METRIC, ours, _UNIT)]
    rows.append(
        _row(work, "LAMMPS granular", peer.version if peer else reason, False, _METRIC, theirs, _UNIT)
    )
    ratios = [own / other for own, other in zip(ours, theirs, strict=False)]
    rows.append(_row(work, "softbed / LAMMPS", version, True, "ratio", ratios, "1"))
    return rows


def _row(
    work: Work, subject: str, version: str, own: bool, metric: str, values: list[float], unit: str
) -> BenchRow:
    value = median(values) if values else None
    return BenchRow(work.name, subject, version, own, metric, value, unit, len(values))


def _own_seconds(work: Work) -> float:
    from synth.dem.bed import contact_law
    from synth.dem.solver import Solver

    solver = Solver(
        work.bed.grains,
        contact_law(work.scene),
        work.scene.bed.width,
        work.time_step,
        gravity=work.gravity,
    )
    solver.advance(work.warm_up)
    began = time.perf_counter()
    solver.advance(work.steps)
    return time.perf_counter() - began


def _peer_seconds(work: Work, peer: Lammps, ranks: int) -> float:
    from synth.dem.bed import contact_law
    from synth.dem.contact_law import ContactLaw
    from synth.dem.solver import SKIN

    law = contact_law(work.scene)
    assert isinstance(law, ContactLaw)
    return peer.seconds(
        work.bed.grains,
        law,
        width=work.scene.bed.width,
        gravity=work.gravity,
        time_step=work.time_step,
        skin=SKIN * work.scene.bed.grain_diameter,
        steps=work.steps,
        warm_up=work.warm_up,
        ranks=ranks,
    )


_DIGEST = """
import hashlib, sys
from synth.devices import start_taichi
start_taichi(threads=int(sys.argv[1]))
from synth.dem.bed import contact_law, settled_bed
from synth.dem.solver import Solver
from validation.bench.dem import _work
work = _work(int(sys.argv[2]), 1)
scene = work.scene
solver = Solver(work.bed.grains, contact_law(scene), scene.bed.width, work.time_step, gravity=work.gravity)
solver.advance(1000)
grains = solver.read_grains()
values = (grains.position, grains.velocity, grains.angle, grains.spin)
print(hashlib.sha256(b"".join(value.tobytes() for value in values)).hexdigest())
"""


def _same_bytes(grain_count: int) -> BenchRow:
    """1 where one thread and every core give the same bytes after 1000 steps, each in its own process."""
    counts = sorted({1, os.cpu_count() or 1})
    digests = {
        subprocess.run(
            [sys.executable, "-c", _DIGEST, str(threads), str(grain_count)],
            capture_output=True,
            text=True,
            check=True,
        ).stdout.split()[-1]
        for threads in counts
    }
    case = f"1000 steps on {' and '.join(map(str, counts))} threads"
    same = float(len(digests) == 1)
    return BenchRow(case, "softbed", package_version("softbed"), True, "same bytes", same, "1", len(counts))
