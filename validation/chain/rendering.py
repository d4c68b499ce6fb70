"""Recording to footage."""

from typing import TYPE_CHECKING

from validation.chain.simulation import adopt, simulated_scene
from validation.chain.step import Work, made_by, require_step, skips
from validation.manifest import RunFolderError, key_of
from validation.material import Material
from validation.run_folder import RunFolder
from validation.terminal import Terminal

if TYPE_CHECKING:
    from soft import AnalysisSettings
    from synth import AnyScene


def render(run: RunFolder, *, work: Work, terminal: Terminal) -> None:
    """Write `footage/` from the recording and the scene of a run.

    Raises
    ------
    RunFolderError
        There is no recording of this scene.
    """
    import synth

    scene = simulated_scene(run)
    adopt(run, scene)
    key = _render_key(run, scene)
    if skips(run, "render", key, terminal):
        return
    with (
        synth.Recording.open(run.recording) as recording,
        run.writing("render", key) as draft,
        terminal.progress("render") as progress,
    ):
        folder = draft.folder / run.footage.name
        synth.render(recording, scene, folder, device=work.device, threads=work.threads, progress=progress)


def footage_of(run: RunFolder, settings: "AnalysisSettings | None" = None) -> Material:
    """Open the pictures of a run; `settings` say which are used, and how.

    Raises
    ------
    RunFolderError
        There are none of this scene.
    """
    hint = f"softbed render {run.path}"
    if not run.scene.is_file():
        raise RunFolderError(
            f"{run.path}: no footage of its own: give the folder of the pictures that were "
            "analyzed, and this one as --results (figure) or --out (other commands)"
        )
    scene = simulated_scene(run)
    require_step(run, "render", _render_key(run, scene), hint)
    return Material.open(run.footage, settings)


def _render_key(run: RunFolder, scene: "AnyScene") -> str:
    recording = run.manifest.steps["simulate"].facts["digest"]
    return key_of(
        step="render",
        made_by=made_by("numpy", "scipy", "taichi", "opencv-python-headless"),
        recording=recording,
        scene=scene.hash,
    )
