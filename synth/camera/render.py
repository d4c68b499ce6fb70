"""A recording in, footage out: pictures and the truth about them, streamed frame by frame."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from synth.footage import Footage, frame_name, write_picture, write_sequence

if TYPE_CHECKING:
    from synth.recording import Recording
    from synth.scene import Scene


def render(
    recording: "Recording",
    scene: "Scene",
    folder: Path,
    *,
    device: str = "cpu",
    threads: int | None = None,
    progress: Callable[[int, int], None] | None = None,
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

    Returns
    -------
    Footage
        The footage just written, opened.

    Raises
    ------
    ValueError
        A recording with fewer than two frames, one without soil in view, or a folder that holds something.
    """
    from synth.camera.cover import cover
    from synth.camera.picture import take_picture
    from synth.devices import start_taichi
    from synth.truth import grains_and_motion, pair_truth
    from synth.truth_file import TruthWriter

    _check(recording, folder)
    start_taichi(device, threads)
    (folder / "frames").mkdir(parents=True, exist_ok=True)
    grains, motion = grains_and_motion(recording, scene)
    placement, count = motion.start(), recording.frame_count
    with TruthWriter(folder / "truth.nc", scene, recording.data["time"].values) as writer:
        for frame in range(count):
            covered = cover(scene, recording, grains, placement)
            write_picture(folder / frame_name(frame), take_picture(scene, grains, covered, frame))
            if frame + 1 < count:
                following = motion.advance(placement)
                around = motion.surroundings(placement, frame + 1)
                writer.write(
                    frame, pair_truth(scene, recording, grains, covered, around, placement, following)
                )
                placement = following
            if progress is not None:
                progress(frame + 1, count)
    write_sequence(folder, scene.timing.frame_rate, scene.camera.metres_per_pixel, count)
    return Footage.open(folder)


def _check(recording: "Recording", folder: Path) -> None:
    if recording.frame_count < 2:
        raise ValueError(f"frame_count = {recording.frame_count}: two frames are needed to make footage")
    if folder.exists() and any(folder.iterdir()):
        raise ValueError(f"{folder}: an empty folder is needed")
