"""How fast pictures are made: the default scene's camera over a recording that needs no simulation."""

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

FRAME_COUNT = 60
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
    total = len(supersampling) * repeats
    scenes = [_scene(sampling) for sampling in supersampling]
    recording = rolling_field(scenes[0], FRAME_COUNT)  # however fine the samples, the same
    runs: list[list[_Rendering]] = [[] for _ in scenes]
    for done in range(total):
        case = done // repeats
        runs[case].append(_rendered(recording, scenes[case], threads))
        if progress is not None:
            progress(done + 1, total)
    # Micro-grains are counted in this process: only now, lest the memory for it count, too.
    return [row for case, scene in enumerate(scenes) for row in _rows(scene, recording, runs[case])]


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
    memory : int
        Bytes that all processes together hold at the last picture.
    clock : StageClock
    """

    start: float
    rate: float
    processor: float
    memory: int
    clock: "StageClock"

    @property
    def first(self) -> int:
        """Pictures that are not looked at: of processes that take turns, the first of each."""
        return max(len(self.clock.elsewhere), 1)


def _rendered(recording: "Recording", scene: "SoilBinScene", threads: int | None) -> _Rendering:
    from synth.camera.render import render
    from synth.camera.stages import StageClock
    from synth.memory import memory_share

    clock, times, processor, held = StageClock(), [time.perf_counter()], [], []

    def frame_done(*_: int) -> None:
        times.append(time.perf_counter())
        processor.append(time.process_time())
        if len(processor) == FRAME_COUNT:
            held.append(memory_share())
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
    memory = held[0] + sum(one.memory for one in clock.elsewhere)
    return _Rendering(times[1] - times[0], rate, used, memory, clock)


def _rows(scene: "SoilBinScene", recording: "Recording", runs: list[_Rendering]) -> list[BenchRow]:
    camera, version = scene.camera, package_version("softbed")
    case = f"{camera.width} x {camera.height} px, {camera.supersampling} x {camera.supersampling} samples"

    def row(metric: str, values: list[float], unit: str) -> BenchRow:
        return BenchRow(case, "softbed", version, True, metric, median(values), unit, len(values))

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
    return [*rows, row("memory", [run.memory / 1024**3 for run in runs], "GiB")]


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
