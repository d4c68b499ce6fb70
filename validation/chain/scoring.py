"""Soil flow and truth to scores and report."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from validation.chain.step import made_by, skips
from validation.manifest import file_digest, key_of
from validation.material import Material
from validation.methods import Method
from validation.run_folder import RunFolder
from validation.scoring.method_scores import score_methods
from validation.scoring.score import ScoreError, Scores
from validation.terminal import Terminal
from validation.versions import package_versions

if TYPE_CHECKING:
    import xarray as xr


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
        made_by=made_by(),
        truth=file_digest(material.truth),
        analyses=list(analyses.items()),
        scene=[labels.scene, labels.seed, labels.quick],
    )
    if not skips(run, "score", key, terminal):
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
            seconds = {m.name: _seconds_per_pair(m, flows[m.name]) for m in methods}
            results = score_methods(footage, flows, seconds=seconds, progress=progress)
    finally:
        for flow in flows.values():
            flow.close()
    with run.writing("score", key) as draft:
        Scores(labels.scene, labels.seed, labels.quick, results, package_versions()).write(
            draft.folder / run.scores.name
        )


def report(run: RunFolder, material: Material, methods: Sequence[Method], *, terminal: Terminal) -> None:
    """Write `report.html`."""
    from validation.report import write_report

    key = key_of(
        step="report",
        made_by=made_by(),
        scores=file_digest(run.scores),
        pictures=material.digest,
        scene=run.manifest.scene_hash,
        recording=run.manifest.files.get(run.recording.name),
    )
    if skips(run, "report", key, terminal):
        return
    with run.writing("report", key) as draft, terminal.progress("report"):
        write_report(draft.folder / run.report.name, run, material, methods)


def _seconds_per_pair(method: Method, flow: "xr.Dataset") -> float | None:
    """Wall time as the analysis took it; what was measured elsewhere tells none."""
    return None if method.is_files else float(flow.attrs["seconds_per_pair"])
