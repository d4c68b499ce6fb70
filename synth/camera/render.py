"""A recording in, footage out: pictures and the truth about them, streamed frame by frame."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from synth.camera.stages import StageClock
from synth.footage import Footage, write_sequence

if TYPE_CHECKING:
    from synth.camera.writing import FootageWriter
    from synth.recording import Recording
    from synth.scene import Scene

_WORTH_A_PROCESS = 5e6
"""px of all pictures; fewer are written before another process has come up."""


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
    from synth.camera.writing import FootageWriter
    from synth.camera.writing_end import Footing
    from synth.devices import start_taichi

    _check(recording, folder)
    start_taichi(device, threads)
    (folder / "frames").mkdir(parents=True, exist_ok=True)
    clock = clock or StageClock()
    shape = scene.camera.height, scene.camera.width
    footing = Footing(folder, scene, recording.data["time"].values, shape)
    with FootageWriter(footing, apart=_write_apart(scene, recording), clock=clock) as writer:
        _render_frames(as_seen(recording, scene), scene, writer, clock, progress)
    write_sequence(folder, scene.timing.frame_rate, scene.camera.metres_per_pixel, recording.frame_count)
    return Footage.open(folder)


def _write_apart(scene: "Scene", recording: "Recording") -> bool:
    from synth.devices import thread_count

    pixels = recording.frame_count * scene.camera.height * scene.camera.width
    return thread_count() > 1 and pixels >= _WORTH_A_PROCESS and hasattr(os, "memfd_create")


def _render_frames(
    recording: "Recording",
    scene: "Scene",
    writer: "FootageWriter",
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
        with clock.stage("waiting"):
            room = writer.room()
        covered = photographer.light(placement, previous, room.light)
        writer.write_picture(room, frame)
        if frame + 1 < count:
            with clock.stage("moving"):
                following = motion.advance(placement)
            with clock.stage("truth"):
                pair = pair_truth(scene, recording, covered, motion, placement, following, arrays=room.truth)
            writer.write_truth(room, pair)
            placement, previous = following, placement
        if progress is not None:
            progress(frame + 1, count)


def _check(recording: "Recording", folder: Path) -> None:
    if recording.frame_count < 2:
        raise ValueError(f"frame_count = {recording.frame_count}: two frames are needed to make footage")
    if folder.exists() and any(folder.iterdir()):
        raise ValueError(f"{folder}: an empty folder is needed")
