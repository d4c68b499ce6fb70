"""The frames of a recording, one by one: light and truth."""

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from synth.camera.motion import Motion
    from synth.camera.placements import Step
    from synth.camera.stages import StageClock
    from synth.camera.writing import FootageWriter
    from synth.recording import Recording
    from synth.scene import Scene


def make_frames(
    recording: "Recording",
    scene: "Scene",
    writer: "FootageWriter",
    clock: "StageClock",
    steps: "Callable[[Motion], Iterator[Step]]",
    frame_done: Callable[[int], None],
) -> None:
    """Make frames, and have them written. Taichi must have been started.

    Parameters
    ----------
    recording : Recording
        As the camera sees it: `synth.camera.nuisance.as_seen`.
    steps : callable
        Gives the frames to be made, from the way micro-grains move.
    frame_done : callable
        Called with every frame's number after it was made.
    """
    from synth.camera.pair_truth import pair_truth
    from synth.camera.photographer import Photographer
    from synth.truth import grains_and_motion

    with clock.stage("strewing"):
        grains, motion = grains_and_motion(recording, scene)
    photographer = Photographer(scene, recording, grains, motion, clock)
    for step in steps(motion):
        with clock.stage("waiting"):
            room = writer.room()
        covered = photographer.light(step.placement, step.previous, room.light)
        writer.write_picture(room, step.frame)
        if step.following is not None:
            with clock.stage("truth"):
                pair = pair_truth(
                    scene, recording, covered, motion, step.placement, step.following, arrays=room.truth
                )
            writer.write_truth(room, pair)
        frame_done(step.frame)
