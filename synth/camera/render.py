"""A recording in, footage out: pictures and the truth about them, streamed frame by frame."""

import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from synth.camera.stages import StageClock
from synth.devices import start_taichi, thread_count
from synth.footage import Footage, write_sequence

if TYPE_CHECKING:
    from synth.camera.writing_end import Footing
    from synth.recording import Recording
    from synth.scene import Scene

_WORTH_A_CREW = 40e6
"""px of all pictures; fewer are made before other processes have come up."""


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
    from synth.camera.writing_end import Footing

    _check(recording, folder)
    (folder / "frames").mkdir(parents=True, exist_ok=True)
    clock, threads = clock or StageClock(), threads or thread_count()
    shape = scene.camera.height, scene.camera.width
    footing = Footing(folder, scene, recording.data["time"].values, shape)
    if device == "cpu" and _worth_a_crew(recording, shape, threads):
        from synth.camera.crew import render_in_turn

        render_in_turn(footing, recording, threads=threads, clock=clock, progress=progress)
    else:
        start_taichi(device, threads)
        _render_here(footing, recording, clock, progress)
    write_sequence(folder, scene.timing.frame_rate, scene.camera.metres_per_pixel, recording.frame_count)
    return Footage.open(folder)


def _worth_a_crew(recording: "Recording", shape: tuple[int, int], threads: int) -> bool:
    enough = recording.frame_count * math.prod(shape) >= _WORTH_A_CREW
    return threads > 1 and enough and hasattr(os, "memfd_create")


def _render_here(
    footing: "Footing",
    recording: "Recording",
    clock: StageClock,
    progress: Callable[[int, int], None] | None,
) -> None:
    from synth.camera.frames import make_frames
    from synth.camera.nuisance import as_seen
    from synth.camera.placements import every_step
    from synth.camera.writing import writing_beside

    count = recording.frame_count

    def frame_done(frame: int) -> None:
        if progress is not None:
            progress(frame + 1, count)

    with writing_beside(footing, clock) as writer:
        seen = as_seen(recording, footing.scene)
        make_frames(
            seen, footing.scene, writer, clock, lambda motion: every_step(motion, count, clock), frame_done
        )


def _check(recording: "Recording", folder: Path) -> None:
    if recording.frame_count < 2:
        raise ValueError(f"frame_count = {recording.frame_count}: two frames are needed to make footage")
    if folder.exists() and any(folder.iterdir()):
        raise ValueError(f"{folder}: an empty folder is needed")
