"""An analytic scene in, footage out."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from synth.footage import frame_name, write_picture, write_sequence

if TYPE_CHECKING:
    from synth.recording import Recording
    from synth.scene import AnalyticScene


def render_analytic(
    recording: "Recording",
    scene: "AnalyticScene",
    folder: Path,
    *,
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Write the pictures of a scene and the truth of every consecutive pair into an empty folder."""
    from synth.analytic.picture import expose, light_of, strew
    from synth.analytic.truth import analytic_truth
    from synth.truth_file import TruthWriter

    (folder / "frames").mkdir(parents=True, exist_ok=True)
    grains, count = strew(scene), scene.timing.frame_count
    with TruthWriter(folder / "truth.nc", scene, recording.data["time"].values) as writer:
        for frame in range(count):
            write_picture(folder / frame_name(frame), expose(scene, light_of(scene, grains, frame), frame))
            if frame + 1 < count:
                writer.write(frame, analytic_truth(scene, frame, frame + 1))
            if progress is not None:
                progress(frame + 1, count)
    write_sequence(folder, scene.timing.frame_rate, scene.camera.metres_per_pixel, count)
