"""How fast pictures are made: the default scene's camera over a recording that needs no simulation."""

import resource
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING

import numpy as np

from validation.bench.rolling_field import rolling_field
from validation.bench.rows import BenchRow
from validation.versions import package_version

if TYPE_CHECKING:
    from synth import Recording
    from synth.camera.stages import StageClock
    from synth.scene import SoilBinScene

FRAME_COUNT = 48
"""So many that two processes share them."""
SUPERSAMPLING = (4, 6)
"""The least a scene may have, and the default scene's."""


def bench_render(
    *,
    supersampling: Sequence[int] = SUPERSAMPLING,
    repeats: int = 5,
    threads: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> list[BenchRow]:
    """Pictures with truth a second, by stage, and the memory for it, of `rolling_wheel` at its full size.

    Parameters
    ----------
    supersampling : sequence of int
        Samples along each side of a pixel; one case each.
    repeats : int
        Renderings of `FRAME_COUNT` frames; rows give the median.
    threads : int, optional
        Default: every core.
    """
    rows: list[BenchRow] = []
    total = len(supersampling) * repeats
    for case, sampling in enumerate(supersampling):
        scene = _scene(sampling)
        recording = rolling_field(scene, FRAME_COUNT)
        runs: list[_Rendering] = []
        for repeat in range(repeats):
            runs.append(_rendered(recording, scene, threads))
            if progress is not None:
                progress(case * repeats + repeat + 1, total)
        rows += _rows(scene, recording, runs)
    return rows


def _scene(sampling: int) -> "SoilBinScene":
    from synth.scene import SoilBinScene, load_scene, parse_scene

    tables = load_scene("rolling_wheel").to_dict()
    tables["camera"] |= {"supersampling": sampling}
    scene = parse_scene(tables)
    assert isinstance(scene, SoilBinScene)
    return scene


@dataclass(frozen=True)
class _Rendering:
    """What one rendering took.

    Attributes
    ----------
    start : float
        Seconds until the first picture is written: texture is strewn, and processes come up.
    rate : float
        Pictures a second after that.
    processor : float
        Seconds of all cores together for each of these: another program on the machine hardly changes them.
    clock : StageClock
    """

    start: float
    rate: float
    processor: float
    clock: "StageClock"

    @property
    def first(self) -> int:
        """Pictures that are not looked at: of processes that take turns, the first of each."""
        return max(len(self.clock.elsewhere), 1)


def _rendered(recording: "Recording", scene: "SoilBinScene", threads: int | None) -> _Rendering:
    from synth.camera.render import render
    from synth.camera.stages import StageClock

    clock, times, processor = StageClock(), [time.perf_counter()], []

    def frame_done(*_: int) -> None:
        times.append(time.perf_counter())
        processor.append(time.process_time())
        if len(processor) == 1:
            clock.seconds.clear()  # kernels were loaded

    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "footage"
        render(recording, scene, folder, threads=threads, progress=frame_done, clock=clock).close()
        frame_done()
    # Processes that take turns have their first pictures at about the same time.
    first = max(len(clock.elsewhere), 1)
    rate = (FRAME_COUNT - first) / (times[-1] - times[first])
    elsewhere = sum(one.processor for one in clock.elsewhere) / first
    used = (processor[-1] - processor[first - 1]) / (FRAME_COUNT - first) + elsewhere
    return _Rendering(times[1] - times[0], rate, used, clock)


def _rows(scene: "SoilBinScene", recording: "Recording", runs: list[_Rendering]) -> list[BenchRow]:
    camera, version = scene.camera, package_version("softbed")
    case = f"{camera.width} x {camera.height} px, {camera.supersampling} x {camera.supersampling} samples"

    def row(metric: str, values: list[float], unit: str) -> BenchRow:
        return BenchRow(case, "softbed", version, True, metric, median(values), unit, len(values))

    own = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024**2
    peak = own + max(map(_memory_elsewhere, runs)) / 1024**3
    visible, in_view = _micro_grains(scene, recording)
    rows = [
        row("pictures with truth", [run.rate for run in runs], "1/s"),
        row("until the first picture", [run.start for run in runs], "s"),
        row("processor time", [run.processor for run in runs], "s/picture"),
        row("micro-grains that are seen", [float(visible)], "1"),
        row("micro-grains in view, hidden ones too", [float(in_view)], "1"),
    ]
    for stage in runs[0].clock.seconds:
        seconds = [run.clock.seconds[stage] / (FRAME_COUNT - run.first) for run in runs]
        rows.append(row(stage, seconds, "s/picture"))
    return [*rows, row("peak memory so far, of all processes", [peak], "GiB")]


def _memory_elsewhere(run: _Rendering) -> int:
    """Bytes of other processes; what they share counts once."""
    others = run.clock.elsewhere
    shared = max((one.shared_memory for one in others), default=0)
    return shared + sum(one.private_memory for one in others)


def _micro_grains(scene: "SoilBinScene", recording: "Recording") -> tuple[int, int]:
    """Micro-grains that cover a sample of the first picture, and those that lie in it."""
    from synth.camera.cover import cover
    from synth.devices import start_taichi
    from synth.truth import grains_and_motion

    start_taichi()
    from synth.camera.cover_kernels import IMPLEMENT, NOTHING

    grains, motion = grains_and_motion(recording, scene)
    covered = cover(scene, recording, grains, motion.start())
    keys = np.unique(covered.samples)
    keys = keys[(keys != IMPLEMENT) & (keys != NOTHING)]
    seen = np.unique(covered.tiled.grain[keys & covered.tiled.index_mask])
    return len(seen), len(np.unique(covered.tiled.grain))
