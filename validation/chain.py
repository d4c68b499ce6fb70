"""The steps from a scene to a scored report, each skipped where its result is there and whole."""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from validation.exchange import Field, write_fields
from validation.manifest import RunFolderError, file_digest, key_of
from validation.material import Material
from validation.methods import DEFAULT, Method
from validation.run_folder import RunFolder
from validation.score import MethodScore, ScoreError, Scores, score_flows
from validation.terminal import Terminal
from validation.versions import package_version, package_versions

if TYPE_CHECKING:
    import xarray as xr

    from synth import AnyScene, Recording

_NEVER_SKIPPED = "a function of your own, whose code may have changed"


@dataclass(frozen=True)
class Work:
    """How the work is done; results do not depend on it.

    Attributes
    ----------
    device : {"cpu", "cuda"}
        Where kernels run.
    threads : int or None
        None: every core.
    """

    device: str = "cpu"
    threads: int | None = None


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
    _adopt(run, scene)
    key = _simulate_key(scene)
    done = _skips(run, "simulate", key, terminal)
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


def render(run: RunFolder, *, work: Work, terminal: Terminal) -> None:
    """Write `footage/` from the recording and the scene of a run.

    Raises
    ------
    RunFolderError
        There is no recording of this scene.
    """
    import synth

    scene = _simulated_scene(run)
    _adopt(run, scene)
    key = _render_key(run, scene)
    if _skips(run, "render", key, terminal):
        return
    with (
        synth.Recording.open(run.recording) as recording,
        run.writing("render", key) as draft,
        terminal.progress("render") as progress,
    ):
        folder = draft.folder / run.footage.name
        synth.render(recording, scene, folder, device=work.device, threads=work.threads, progress=progress)


def export_vtk(run: RunFolder, *, terminal: Terminal) -> None:
    """Write `vtk/` from the recording and the scene of a run.

    Raises
    ------
    RunFolderError
        There is no recording of this scene.
    """
    import synth
    from synth.dataset.export import export_vtk as write_vtk

    scene = _simulated_scene(run)
    digest = run.manifest.steps["simulate"].facts["digest"]
    key = key_of(step="export vtk", made_by=_made_by(), recording=digest, scene=scene.simulation_hash)
    if _skips(run, "export vtk", key, terminal):
        return
    recording = synth.Recording.read(run.recording)
    with run.writing("export vtk", key) as draft, terminal.progress("export") as progress:
        folder = draft.folder / run.vtk.name
        folder.mkdir()
        write_vtk(recording, scene, folder, progress=progress)


def export_fields(run: RunFolder, material: Material, file_format: str, *, terminal: Terminal) -> None:
    """Write `<file_format>/`: the truth and what every method measured.

    Raises
    ------
    RunFolderError
        There is neither.
    """
    methods = analyzed_methods(run, material, terminal=terminal)
    if not methods and not material.has_truth:
        raise RunFolderError(f"{material.folder}: neither truth nor analysis: nothing to export")
    step = f"export {file_format}"
    key = key_of(
        step=step,
        made_by=_made_by("numpy", "opencv-python-headless", "h5netcdf"),
        pictures=material.digest,
        truth=file_digest(material.truth) if material.has_truth else None,
        analyses={method.slug: file_digest(run.analysis(method.slug)) for method in methods},
    )
    if _skips(run, step, key, terminal):
        return
    with run.writing(step, key) as draft, terminal.progress(step) as progress:
        folder = draft.folder / file_format
        folder.mkdir()
        with _fields(run, material, methods) as fields:
            write_fields(fields, material.sequence, file_format, folder, progress=progress)


@contextmanager
def _fields(run: RunFolder, material: Material, methods: Sequence[Method]) -> "Iterator[list[Field]]":
    """Open the truth, if it is known, and what each method measured."""
    import soft
    import synth

    with ExitStack() as stack:
        fields = []
        if material.has_truth:
            footage = stack.enter_context(synth.Footage.open(material.folder))
            fields.append(Field("truth", footage.truths))
        for method in methods:
            flow = stack.enter_context(soft.read_soil_flow(run.analysis(method.slug)))
            fields.append(Field(method.slug, flow))
        yield fields


def footage_of(run: RunFolder) -> Material:
    """Open the pictures of a run.

    Raises
    ------
    RunFolderError
        There are none of this scene.
    """
    hint = f"softbed render {run.path}"
    if not run.scene.is_file():
        raise RunFolderError(f"{run.path}: no footage of its own: give the pictures' folder")
    scene = _simulated_scene(run)
    _require(run, "render", _render_key(run, scene), hint)
    return Material.open(run.footage)


def _simulated_scene(run: RunFolder) -> "AnyScene":
    """Read the scene of a run, and make sure that its recording is there and whole."""
    scene = run_scene(run)
    _require(run, "simulate", _simulate_key(scene), f"softbed simulate SCENE {run.path}")
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


def analyze(
    run: RunFolder,
    material: Material,
    method: Method,
    *,
    soil: str = "bright",
    vertical: bool = False,
    work: Work,
    terminal: Terminal,
) -> None:
    """Write `analysis/<method>.nc`."""
    import soft

    key = _analyze_key(material, method, soil, vertical)
    step = _analyze_step(method)
    if _skips(run, step, key, terminal, never=_NEVER_SKIPPED if method.is_function else None):
        return
    with run.writing(step, key) as draft, terminal.progress(f"analyze with {method.name}") as progress:
        path = draft.folder / "analysis" / f"{method.slug}.nc"
        path.parent.mkdir()
        soft.analyze(
            material.sequence,
            method=method.name,
            soil=soil,
            vertical=vertical,
            threads=work.threads,
            device=work.device,
            progress=progress,
            path=path,
        ).close()
        draft.facts |= {
            "method": method.name,
            "pictures": material.digest,
            "soil": soil,
            "vertical": vertical,
        }


def draw(run: RunFolder, material: Material, methods: Sequence[Method], *, terminal: Terminal) -> None:
    """Write `figures/` of measurements on pictures without truth."""
    import soft

    paths = {method.slug: run.analysis(method.slug) for method in methods}
    key = key_of(step="figures", made_by=_made_by(), analyses={s: file_digest(p) for s, p in paths.items()})
    if _skips(run, "figures", key, terminal):
        return
    with run.writing("figures", key) as draft, terminal.progress("figures") as progress:
        for done, (slug, path) in enumerate(paths.items(), start=1):
            folder = draft.folder / run.figures.name / slug
            folder.mkdir(parents=True)
            with soft.read_soil_flow(path) as flow:
                soft.write_figures(flow, material.sequence, folder)
            progress(done, len(paths))


def score(run: RunFolder, material: Material, methods: Sequence[Method], *, terminal: Terminal) -> Scores:
    """Write `scores.json` for methods that have been analyzed.

    Raises
    ------
    ScoreError
        There is no truth about the pictures, or a flow is not of them.
    """
    require_truth(material)
    analyses = {method.name: file_digest(run.analysis(method.slug)) for method in methods}
    if not run.scene.is_file():
        _label_as(run, material)
    labels = run.manifest
    key = key_of(
        step="score",
        made_by=_made_by(),
        truth=file_digest(material.truth),
        analyses=list(analyses.items()),
        scene=[labels.scene, labels.seed, labels.quick],
    )
    if not _skips(run, "score", key, terminal):
        _write_scores(run, key, material, methods, terminal)
    return Scores.read(run.scores)


def require_truth(material: Material) -> None:
    """Refuse, before long work is done, pictures that nothing is known about.

    Raises
    ------
    ScoreError
        There is no truth about them.
    """
    if not material.has_truth:
        raise ScoreError(f"{material.folder}: holds no truth.nc and sequence.toml: nothing to score against")


def _label_as(run: RunFolder, material: Material) -> None:
    """Say in a folder without a scene of its own which scene the footage it scores is of."""
    import synth

    with synth.Footage.open(material.folder) as footage:
        told = footage.attributes
    run.label(
        scene=str(told["scene"]),
        scene_hash=str(told["scene_hash"]),
        seed=int(told["seed"]),
        quick=bool(told["quick"]),
    )


def _write_scores(
    run: RunFolder, key: str, material: Material, methods: Sequence[Method], terminal: Terminal
) -> None:
    import soft
    import synth

    labels = run.manifest
    flows: dict[str, xr.Dataset] = {}
    try:
        flows |= {method.name: soft.read_soil_flow(run.analysis(method.slug)) for method in methods}
        with synth.Footage.open(material.folder) as footage, terminal.progress("score") as progress:
            summaries = score_flows(footage, flows, progress=progress)
        seconds = {m.name: _seconds_per_pair(m, flows[m.name]) for m in methods}
    finally:
        for flow in flows.values():
            flow.close()
    results = {name: MethodScore(seconds[name], strata) for name, strata in summaries.items()}
    with run.writing("score", key) as draft:
        Scores(labels.scene, labels.seed, labels.quick, results, package_versions()).write(
            draft.folder / run.scores.name
        )


def report(run: RunFolder, material: Material, methods: Sequence[Method], *, terminal: Terminal) -> None:
    """Write `report.html`."""
    from validation.report import write_report

    key = key_of(
        step="report",
        made_by=_made_by(),
        scores=file_digest(run.scores),
        pictures=material.digest,
        scene=run.manifest.scene_hash,
        recording=run.manifest.files.get(run.recording.name),
    )
    if _skips(run, "report", key, terminal):
        return
    with run.writing("report", key) as draft, terminal.progress("report"):
        write_report(draft.folder / run.report.name, run, material, methods)


def analyzed_methods(run: RunFolder, material: Material, *, terminal: Terminal) -> list[Method]:
    """Methods whose analysis of these very pictures is there; says which are left out."""
    found = []
    for step, record in run.manifest.steps.items():
        if not step.startswith("analyze "):
            continue
        method = Method(str(record.facts.get("method")))
        reason = run.why_do(step, record.key)
        if record.facts.get("pictures") != material.digest:
            reason = "of other pictures than these"
        if reason is None:
            found.append(method)
        else:
            terminal.say(f"{step}: {reason}: left out")
    return found


def require_methods(methods: Sequence[Method]) -> None:
    """Refuse, before long work is done, a method that does not exist.

    Raises
    ------
    soft.FlowError
        A name that leads nowhere.
    """
    from soft.flow import find_estimator

    for method in methods:
        find_estimator(method.name)


def methods_to_score(
    run: RunFolder, material: Material, asked: Sequence[Method], *, work: Work, terminal: Terminal
) -> list[Method]:
    """Choose the methods asked for, analyzed where needed; else all analyzed ones; else the default."""
    require_truth(material)
    methods = list(asked) or analyzed_methods(run, material, terminal=terminal)
    if asked or not methods:
        methods = methods or [Method(DEFAULT)]
        for method in methods:
            analyze(run, material, method, work=work, terminal=terminal)
    return methods


def _refuse_other(run: RunFolder, scene: "AnyScene") -> None:
    """Keep hours of computing from being lost to a mistyped folder; pictures may be made anew."""
    if not (run.recording.is_file() and run.scene.is_file()):
        return
    held = run_scene(run)
    if held.simulation_hash != scene.simulation_hash:
        quick = ", quick" if held.quick else ""
        raise RunFolderError(
            f"{run.path}: holds another simulation (scene {held.name!r}, seed {held.seed}{quick}): "
            "choose another folder, or replace it with --overwrite"
        )


def _adopt(run: RunFolder, scene: "AnyScene") -> None:
    """Make `scene` the run's: `scene.toml` and the labels of the manifest."""
    if run.why_do("scene", scene.hash) is not None:
        with run.writing("scene", scene.hash) as draft:
            (draft.folder / run.scene.name).write_text(scene.to_toml(), encoding="utf-8")
    run.label(scene=scene.name, scene_hash=scene.hash, seed=scene.seed, quick=scene.quick)


def _skips(run: RunFolder, step: str, key: str, terminal: Terminal, *, never: str | None = None) -> bool:
    reason = run.why_do(step, key)
    if reason is None and never is None:
        terminal.say(f"{step}: done before, its files are whole: skipped")
        return True
    if step in run.manifest.steps:
        terminal.say(f"{step}: {reason or never}: doing it again")
    return False


def _require(run: RunFolder, step: str, key: str, command: str) -> None:
    reason = run.why_do(step, key)
    if reason is not None:
        raise RunFolderError(f"{run.path}: {step}: {reason}: run `{command}` first")


def _simulate_key(scene: "AnyScene") -> str:
    return key_of(step="simulate", made_by=_made_by("numpy", "scipy", "taichi"), scene=scene.simulation_hash)


def _render_key(run: RunFolder, scene: "AnyScene") -> str:
    recording = run.manifest.steps["simulate"].facts["digest"]
    return key_of(
        step="render",
        made_by=_made_by("numpy", "scipy", "taichi", "opencv-python-headless"),
        recording=recording,
        scene=scene.hash,
    )


def _analyze_step(method: Method) -> str:
    return f"analyze {method.slug}"


def _analyze_key(material: Material, method: Method, soil: str, vertical: bool) -> str:
    return key_of(
        step="analyze",
        made_by=_made_by("numpy", "opencv-python-headless", "scikit-learn", *_needs(method)),
        pictures=material.digest,
        method=method.name,
        files=_flow_files(method),
        soil=soil,
        vertical=vertical,
    )


def _needs(method: Method) -> list[str]:
    from soft.flow import NEEDS

    return [NEEDS[method.name]] if method.name in NEEDS else []


def _flow_files(method: Method) -> list[str]:
    """SHA-256 of every file of flow measured elsewhere, in order."""
    if not method.is_files:
        return []
    from soft.flow import FlowFiles

    return [file_digest(path) for path in FlowFiles(method.folder).sources]


def _seconds_per_pair(method: Method, flow: "xr.Dataset") -> float | None:
    """Wall time as the analysis took it; what was measured elsewhere tells none."""
    return None if method.is_files else float(flow.attrs["seconds_per_pair"])


def _made_by(*packages: str) -> dict[str, str]:
    """Versions of this program and of the packages whose numbers a step's result is made of."""
    return {name: package_version(name) for name in ("softbed", *packages)}
