"""Scene to recording."""

from typing import TYPE_CHECKING

from validation.chain.step import Work, made_by, require_step, skips
from validation.manifest import RunFolderError, key_of
from validation.run_folder import RunFolder
from validation.terminal import Terminal

if TYPE_CHECKING:
    from synth import AnyScene, Recording


def simulate(
    run: RunFolder,
    scene: "AnyScene",
    *,
    work: Work,
    terminal: Terminal,
    resume: bool = True,
    overwrite: bool = False,
) -> None:
    """Write `scene.toml`, `recording.nc` and `forces.csv`; say how sound the simulation is.

    Parameters
    ----------
    resume : bool
        Go on from the checkpoint of a run that was killed, if there is one; else start anew.
    overwrite : bool
        Replace the recording of another scene or seed.

    Raises
    ------
    RunFolderError
        The folder holds the recording of another scene or seed, and it may not be replaced.
    synth.dem.failures.SimulationError
        It had to stop; what was recorded until then is in `recording-stopped.nc`.
    """
    from synth.dem.checkpoint import remove_checkpoint
    from synth.dem.soundness import attributes_of

    if not overwrite:
        _refuse_other(run, scene)
    adopt(run, scene)
    key = simulate_key(scene)
    done = skips(run, "simulate", key, terminal)
    if done or not resume:
        remove_checkpoint(run.checkpoint)
    if done:
        return
    with run.writing("simulate", key) as draft:
        recording = _simulated(run, scene, work, terminal)
        recording.write(draft.folder / run.recording.name)
        recording.write_forces(draft.folder / run.forces.name)
        draft.facts["digest"] = recording.digest
        draft.facts["soundness"] = soundness = attributes_of(recording.data.attrs)
    _tell_soundness(soundness, terminal)
    run.stopped_recording.unlink(missing_ok=True)
    remove_checkpoint(run.checkpoint)


def _simulated(run: RunFolder, scene: "AnyScene", work: Work, terminal: Terminal) -> "Recording":
    import synth
    from synth.dem.checkpoint import remove_checkpoint
    from synth.dem.failures import SimulationError

    try:
        with terminal.progress("simulate") as progress:
            return synth.simulate(
                scene,
                device=work.device,
                threads=work.threads,
                progress=progress,
                checkpoint=run.checkpoint,
                say=terminal.say,
            )
    except SimulationError as error:
        remove_checkpoint(run.checkpoint)  # going on from it would only stop there again
        if error.recording is None:
            raise
        run.put_aside(run.stopped_recording, error.recording.write)
        raise error.saying(f"what was recorded until then is in {run.stopped_recording}") from None


def _tell_soundness(soundness: dict[str, float], terminal: Terminal) -> None:
    """Say how sound a simulation is, and a warning for each limit that is not kept."""
    from synth.dem.soundness import judge

    judgements = judge(soundness)
    for one in judgements:
        terminal.say(f"  {one.name}: {one.value}" + (f" ({one.limit})" if one.limit else ""))
    for one in judgements:
        if not one.kept:
            terminal.say(f"warning: {one.name} is {one.value}, sound is {one.limit}: {one.advice}")


def simulated_scene(run: RunFolder) -> "AnyScene":
    """Read the scene of a run, and make sure that its recording is there and whole."""
    scene = run_scene(run)
    require_step(run, "simulate", simulate_key(scene), f"softbed simulate SCENE {run.path}")
    return scene


def run_scene(run: RunFolder) -> "AnyScene":
    """Read the scene of a run.

    Raises
    ------
    RunFolderError
        It has none.
    """
    import synth

    if not run.scene.is_file():
        raise RunFolderError(f"{run.scene}: missing: softbed simulate SCENE {run.path}")
    return synth.load_scene(run.scene)


def _refuse_other(run: RunFolder, scene: "AnyScene") -> None:
    """Keep hours of computing from being lost to a mistyped folder; pictures may be made anew."""
    if not (run.recording.is_file() and run.scene.is_file()):
        return
    held = run_scene(run)
    if held.simulation_hash != scene.simulation_hash:
        raise RunFolderError(
            f"{run.path}: holds another simulation ({_in_words(held)}) than asked for ({_in_words(scene)}): "
            "choose another folder, or replace it with --overwrite"
        )


def _in_words(scene: "AnyScene") -> str:
    return f"scene {scene.name!r}, seed {scene.seed}" + (", quick" if scene.quick else "")


def adopt(run: RunFolder, scene: "AnyScene") -> None:
    """Make `scene` the run's: `scene.toml` and the labels of the manifest."""
    if run.why_do("scene", scene.hash) is not None:
        with run.writing("scene", scene.hash) as draft:
            (draft.folder / run.scene.name).write_text(scene.to_toml(), encoding="utf-8")
    run.label(scene=scene.name, scene_hash=scene.hash, seed=scene.seed, quick=scene.quick)


def simulate_key(scene: "AnyScene") -> str:
    """Name all that a recording depends on."""
    return key_of(step="simulate", made_by=made_by("numpy", "scipy", "taichi"), scene=scene.simulation_hash)
