"""How fast a sweep makes sequences, how much two workers gain, and what thousands of them would take."""

import os
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

from validation.bench.rows import BenchRow
from validation.versions import package_version

WORKERS = (1, 2)
MANY = 10_000
"""Sequences whose cost is told."""
CASE: dict[str, Any] = {
    "scene": "rolling_wheel",
    "quick": True,
    "vary": {
        "seed": [0, 1],
        "drive.slip": [0.1, 0.3],
        "lens.blur": [0.6, 1.0],
        "bed.grain_diameter": [4e-3],
        "camera.width": [512],
        "camera.height": [256],
    },
}
"""Eight sequences of four motions in two beds: as many of each as two workers can share evenly."""
_STAGES = {"bed": "s/bed", "simulation": "s/motion", "pictures": "s/sequence"}


@dataclass(frozen=True)
class _Run:
    """One data set made.

    Attributes
    ----------
    seconds : float
        From the command to its end, workers started and data card written.
    facts : list of dict
        Of every sequence.
    """

    seconds: float
    facts: list[dict[str, Any]]


def bench_sweep(
    *, case: dict[str, Any] = CASE, repeats: int = 1, progress: Callable[[int, int], None] | None = None
) -> list[BenchRow]:
    """Make a small data set by one worker and by two, each time from nothing but compiled kernels.

    Parameters
    ----------
    case : dict
        Tables of a sweep file, besides its name and design.
    repeats : int
        Data sets made by each number of workers; rows give the median.
    """
    runs: dict[int, list[_Run]] = {count: [] for count in WORKERS}
    total = 1 + repeats * len(WORKERS)
    with tempfile.TemporaryDirectory(prefix="softbed-bench-") as name, _own_cache(Path(name)):
        sweep = _write_sweep(Path(name), case)
        _made(sweep, Path(name), max(WORKERS))  # kernels are compiled
        for done in range(1, total):
            if progress is not None:
                progress(done, total)
            count = WORKERS[(done - 1) % len(WORKERS)]  # in turn, so that a busy moment meets all
            runs[count].append(_made(sweep, Path(name), count))
    if progress is not None:
        progress(total, total)
    return _rows(runs)


def _write_sweep(folder: Path, case: dict[str, Any]) -> Path:
    import tomli_w

    path = folder / "sweep.toml"
    tables = {"schema_version": 1, "name": "bench", "design": {"kind": "grid"}, **case}
    path.write_text(tomli_w.dumps(tables), encoding="utf-8")
    return path


def _made(sweep: Path, folder: Path, workers: int) -> _Run:
    from synth.dataset.execution import make_data_set
    from synth.dataset.folder import DataSetFolder
    from synth.dataset.loading import load_data_set
    from synth.dataset.summary import read_facts
    from synth.devices import cache_folder

    out = folder / "out"
    for old in (out, cache_folder() / "beds"):
        shutil.rmtree(old, ignore_errors=True)
    started = time.perf_counter()
    make_data_set(sweep, out, workers=workers)
    seconds = time.perf_counter() - started
    names = [one.name for one in load_data_set(out).sequences]
    return _Run(seconds, [read_facts(DataSetFolder(out), name) for name in names])


def _rows(runs: dict[int, list[_Run]]) -> list[BenchRow]:
    facts, version = runs[1][0].facts, package_version("softbed")
    count, frames = len(facts), sum(one["frame_count"] for one in facts)
    motions = len({one["simulation"] for one in facts})
    first = facts[0]
    pictures = f"{first['frame_count']} x {first['width']} x {first['height']} px"
    case = f"{count} sequences, {pictures}, {motions} motions"

    def row(metric: str, value: float, unit: str, repeats: int = len(runs[1])) -> BenchRow:
        return BenchRow(case, "softbed", version, True, metric, value, unit, repeats)

    took = {workers: median(run.seconds for run in several) for workers, several in runs.items()}
    most = max(took)
    size = sum(one["bytes"] for one in facts)
    rows = [row(f"sequences, {_workers(n)}", 3600 * count / seconds, "1/h") for n, seconds in took.items()]
    rows.append(row(f"speed-up, 1 to {most} workers", took[1] / took[most], "1"))
    rows += [row(f"{stage}, 1 worker", _stage(runs[1], stage), unit) for stage, unit in _STAGES.items()]
    rows.append(row("size of a picture with its truth", size / frames, "bytes"))
    rows.append(row(f"{MANY} such sequences", most * took[most] / 3600 * MANY / count, "core h"))
    rows.append(row(f"{MANY} such sequences, size", size / count * MANY / 1e9, "GB"))
    return rows


def _stage(runs: Sequence[_Run], stage: str) -> float:
    """Median of what a stage took; of a shared bed or motion, each once."""
    seconds = {one["seconds"].get(stage) for run in runs for one in run.facts} - {None}
    return median(seconds) if seconds else 0.0


def _workers(count: int) -> str:
    return f"{count} worker" if count == 1 else f"{count} workers"


@contextmanager
def _own_cache(folder: Path) -> Iterator[None]:
    """Beds and kernels of the bench's own, for this process and for its workers."""
    before = os.environ.get("SOFTBED_CACHE")
    os.environ["SOFTBED_CACHE"] = str(folder / "cache")
    try:
        yield
    finally:
        if before is None:
            del os.environ["SOFTBED_CACHE"]
        else:
            os.environ["SOFTBED_CACHE"] = before
