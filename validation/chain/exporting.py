"""What was simulated or measured, in formats of other programs."""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

from validation.chain.analysis import analyzed_methods
from validation.chain.simulation import simulated_scene
from validation.chain.step import made_by, skips
from validation.exchange import Field, write_fields
from validation.manifest import RunFolderError, file_digest, key_of
from validation.material import Material
from validation.methods import Method
from validation.run_folder import RunFolder
from validation.terminal import Progress, Terminal


def export_vtk(run: RunFolder, *, terminal: Terminal) -> None:
    """Write `vtk/` from the recording and the scene of a run.

    Raises
    ------
    RunFolderError
        There is no recording of this scene.
    """
    import synth
    from synth.dataset.export import export_vtk as write_vtk

    scene = simulated_scene(run)
    digest = run.manifest.steps["simulate"].facts["digest"]
    key = key_of(step="export vtk", made_by=made_by(), recording=digest, scene=scene.simulation_hash)
    if skips(run, "export vtk", key, terminal):
        return
    recording = synth.Recording.read(run.recording)
    with run.writing("export vtk", key) as draft, terminal.progress("export") as progress:
        folder = draft.folder / run.vtk.name
        folder.mkdir()
        write_vtk(recording, scene, folder, progress=progress)


def export_fields(
    run: RunFolder,
    material: Material,
    file_format: str,
    *,
    stride: int | None = None,
    terminal: Terminal,
) -> None:
    """Write `<file_format>/`: the truth and what every method measured.

    Parameters
    ----------
    stride : int, optional
        Every how many pixels one is written, where the format lets that be chosen.

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
        made_by=made_by("numpy", "opencv-python-headless", "h5netcdf"),
        pictures=material.digest,
        truth=file_digest(material.truth) if material.has_truth else None,
        analyses={method.slug: file_digest(run.analysis(method.slug)) for method in methods},
        stride=stride,
    )
    if skips(run, step, key, terminal):
        return
    with run.writing(step, key) as draft, terminal.progress(step) as progress:
        folder = draft.folder / file_format
        folder.mkdir()
        if file_format == "mp4":
            _write_films(run, material, methods, folder, progress)
            return
        with _fields(run, material, methods) as fields:
            write_fields(fields, material.sequence, file_format, folder, stride=stride, progress=progress)


def _write_films(
    run: RunFolder, material: Material, methods: Sequence[Method], folder: Path, progress: Progress
) -> None:
    """One film for each method, or one of the truth where nothing was measured."""
    from validation.showing.film import film, truth_film
    from validation.showing.subject import opened_subject

    if not methods:
        truth_film(material, folder / "truth.mp4", progress=progress)
    for method in methods:
        with opened_subject(run.path, run, material, method=method.name) as subject:
            film(subject, folder / f"{method.slug}.mp4", progress=progress)


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
