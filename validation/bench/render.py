"""How fast pictures are made: the default scene's camera over a recording that needs no simulation."""

import resource
import tempfile
import time
from collections.abc import Callable, Sequence
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

FRAME_COUNT = 9
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
    from synth.devices import start_taichi

    start_taichi(threads=threads)
    rows: list[BenchRow] = []
    total = len(supersampling) * repeats
    for case, sampling in enumerate(supersampling):
        scene = _scene(sampling)
        recording = rolling_field(scene, FRAME_COUNT)
        runs: list[StageClock] = []
        rates: list[float] = []
        _rendered(recording, scene)  # kernels are compiled, or read from the cache
        for repeat in range(repeats):
            rate, clock = _rendered(recording, scene)
            rates.append(rate)
            runs.append(clock)
            if progress is not None:
                progress(case * repeats + repeat + 1, total)
        rows += _rows(scene, recording, rates, runs)
    return rows


def _scene(sampling: int) -> "SoilBinScene":
    from synth.scene import SoilBinScene, load_scene, parse_scene

    tables = load_scene("rolling_wheel").to_dict()
    tables["camera"] |= {"supersampling": sampling}
    scene = parse_scene(tables)
    assert isinstance(scene, SoilBinScene)
    return scene


def _rendered(recording: "Recording", scene: "SoilBinScene") -> "tuple[float, StageClock]":
    """Frames a second after the first one, which waits for the texture to be strewn; and the stages."""
    from synth.camera.render import render
    from synth.camera.stages import StageClock

    clock, times = StageClock(), []
    with tempfile.TemporaryDirectory() as folder:
        render(
            recording,
            scene,
            Path(folder) / "footage",
            progress=lambda *_: times.append(time.perf_counter()),
            clock=clock,
        ).close()
        ended = time.perf_counter()
    return (len(times) - 1) / (ended - times[0]), clock


def _rows(
    scene: "SoilBinScene", recording: "Recording", rates: list[float], runs: "list[StageClock]"
) -> list[BenchRow]:
    camera, version = scene.camera, package_version("softbed")
    case = f"{camera.width} x {camera.height} px, {camera.supersampling} x {camera.supersampling} samples"

    def row(metric: str, values: list[float], unit: str) -> BenchRow:
        return BenchRow(case, "softbed", version, True, metric, median(values), unit, len(values))

    visible, in_view = _micro_grains(scene, recording)
    rows = [
        row("pictures with truth", rates, "1/s"),
        row("micro-grains that are seen", [float(visible)], "1"),
        row("micro-grains in view, hidden ones too", [float(in_view)], "1"),
    ]
    for stage in runs[0].seconds:
        unit = "s" if stage == "strewing" else "s/picture"
        frames = 1 if stage == "strewing" else FRAME_COUNT
        rows.append(row(stage, [run.seconds[stage] / frames for run in runs], unit))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024**2
    return [*rows, row("peak memory of the process so far", [peak], "GiB")]


def _micro_grains(scene: "SoilBinScene", recording: "Recording") -> tuple[int, int]:
    """Micro-grains that cover a sample of the first picture, and those that lie in it."""
    from synth.camera.cover import cover
    from synth.camera.cover_kernels import IMPLEMENT, NOTHING
    from synth.truth import grains_and_motion

    grains, motion = grains_and_motion(recording, scene)
    covered = cover(scene, recording, grains, motion.start())
    keys = np.unique(covered.samples)
    keys = keys[(keys != IMPLEMENT) & (keys != NOTHING)]
    seen = np.unique(covered.tiled.grain[keys & covered.tiled.index_mask])
    return len(seen), len(np.unique(covered.tiled.grain))
