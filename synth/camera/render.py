"""A recording in, footage out: pictures and the truth about them, streamed frame by frame."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from synth.camera.stages import StageClock
from synth.camera.writing import BackgroundWriter
from synth.footage import Footage, frame_name, write_picture, write_sequence

if TYPE_CHECKING:
    import numpy as np

    from synth.recording import Recording
    from synth.scene import Scene
    from synth.truth import PairTruth
    from synth.truth_file import TruthWriter


def render(
    recording: "Recording",
    scene: "Scene",
    folder: Path,
    *,
    device: str = "cpu",
    threads: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    clock: StageClock | None = None,
) -> Footage:
    """Take the pictures of a recording and write them with the truth of every consecutive pair.

    Parameters
    ----------
    recording : Recording
    scene : Scene
        The scene it was made with; its tables [camera] [texture] [light] [lens] [sensor] may differ.
    folder : Path
        A fresh folder; it is made where it is missing.
    device, threads
        As in `synth.devices.start_taichi`; results do not depend on the threads.
    progress : callable, optional
        Called with the frames done and the frames in all.
    clock : StageClock, optional
        Adds up how long each stage takes.

    Returns
    -------
    Footage
        The footage just written, opened.

    Raises
    ------
    ValueError
        A recording with fewer than two frames, one without soil in view, or a folder that holds something.
    """
    from synth.camera.nuisance import as_seen
    from synth.devices import start_taichi
    from synth.truth_file import TruthWriter

    _check(recording, folder)
    start_taichi(device, threads)
    (folder / "frames").mkdir(parents=True, exist_ok=True)
    seen = as_seen(recording, scene)
    with (
        TruthWriter(folder / "truth.nc", scene, recording.data["time"].values) as truth,
        BackgroundWriter() as writer,
    ):
        _render_frames(seen, scene, folder, truth, writer, clock or StageClock(), progress)
    write_sequence(folder, scene.timing.frame_rate, scene.camera.metres_per_pixel, recording.frame_count)
    return Footage.open(folder)


def _render_frames(
    recording: "Recording",
    scene: "Scene",
    folder: Path,
    truth: "TruthWriter",
    writer: BackgroundWriter,
    clock: StageClock,
    progress: Callable[[int, int], None] | None,
) -> None:
    from synth.camera.pair_truth import pair_truth
    from synth.camera.photographer import Photographer
    from synth.truth import grains_and_motion

    with clock.stage("strewing"):
        grains, motion = grains_and_motion(recording, scene)
    placement, previous, count = motion.start(), None, recording.frame_count
    photographer = Photographer(scene, recording, grains, motion, clock)
    for frame in range(count):
        light, covered = photographer.light(placement, previous)
        writer.put(partial(_expose_and_write, clock, scene, light, frame, folder / frame_name(frame)))
        if frame + 1 < count:
            with clock.stage("moving"):
                following = motion.advance(placement)
            with clock.stage("truth"):
                pair = pair_truth(scene, recording, grains, covered, motion, placement, following)
            writer.put(partial(_timed_truth, clock, truth, pair))
            placement, previous = following, placement
        if progress is not None:
            progress(frame + 1, count)


def _expose_and_write(clock: StageClock, scene: "Scene", light: "np.ndarray", frame: int, path: Path) -> None:
    from synth.camera.picture import expose

    with clock.stage("exposing"):
        picture = expose(scene, light, frame)
    with clock.stage("writing"):
        write_picture(path, picture)


def _timed_truth(clock: StageClock, truth: "TruthWriter", pair: "PairTruth") -> None:
    with clock.stage("writing"):
        truth.write(pair.first, pair)


def _check(recording: "Recording", folder: Path) -> None:
    if recording.frame_count < 2:
        raise ValueError(f"frame_count = {recording.frame_count}: two frames are needed to make footage")
    if folder.exists() and any(folder.iterdir()):
        raise ValueError(f"{folder}: an empty folder is needed")
