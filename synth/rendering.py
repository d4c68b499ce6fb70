"""Recording -> Footage: the one way in, whatever the scene."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from synth.checksums import write_checksums
from synth.data_card import write_data_card
from synth.footage import Footage

if TYPE_CHECKING:
    from synth.recording import Recording
    from synth.scene import AnyScene


def render(
    recording: "Recording",
    scene: "AnyScene",
    folder: Path,
    *,
    device: str = "cpu",
    threads: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Footage:
    """Take the pictures of a recording and write them with the truth, a data card and checksums.

    Parameters
    ----------
    recording : Recording
    scene : AnyScene
        The scene it was made with; the tables that only pictures depend on may differ.
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
    from synth.camera.render import render as photograph
    from synth.scene import AnalyticScene

    if folder.exists() and any(folder.iterdir()):
        raise ValueError(f"{folder}: an empty folder is needed")
    if isinstance(scene, AnalyticScene):
        from synth.analytic.render import render_analytic

        render_analytic(recording, scene, folder, progress=progress)
    else:
        photograph(recording, scene, folder, device=device, threads=threads, progress=progress).close()
    footage = Footage.open(folder)
    write_data_card(footage, scene)
    write_checksums(folder)
    return footage
