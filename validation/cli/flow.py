"""Commands that measure and score: analyze, score, run."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from validation.cli.app import app
from validation.cli.folders import methods_of_this_folder, opened_material, show_scores, step_document
from validation.cli.options import (
    Camera,
    Debug,
    Device,
    Every,
    FrameRate,
    Json,
    LensFile,
    Masks,
    Methods,
    MetresPerPixel,
    Out,
    OutFolder,
    Overwrite,
    Processes,
    Quick,
    RegionText,
    Resume,
    SceneName,
    Seed,
    Settings,
    Soil,
    Start,
    Stop,
    Stride,
    Threads,
    Vertical,
)
from validation.terminal import Terminal

if TYPE_CHECKING:
    from validation.chain import Work


@app.command()
def analyze(
    path: Annotated[
        Path | None,
        typer.Argument(
            metavar="PATH", help="A run folder, a footage folder, a folder of pictures, or a video."
        ),
    ] = None,
    method: Methods = None,
    out: Out = None,
    settings: Settings = None,
    write_settings: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Write all settings with their defaults, and do nothing else.",
            show_default=False,
        ),
    ] = None,
    metres_per_pixel: MetresPerPixel = None,
    frame_rate: FrameRate = None,
    lens: LensFile = None,
    start: Start = None,
    stop: Stop = None,
    stride: Stride = None,
    every: Every = None,
    region: RegionText = None,
    masks: Masks = None,
    soil: Soil = None,
    camera: Camera = None,
    vertical: Vertical = None,
    threads: Threads = None,
    processes: Processes = 1,
    device: Device = "cpu",
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Measure soil flow in pictures: analysis/METHOD.nc, and figures/ where no truth is known.

    Stopped and called again, it goes on with the pairs that are missing.
    """
    from validation.chain import Work
    from validation.cli.settings import given_settings, settings_written

    terminal = Terminal(json=json)
    if write_settings is not None:
        settings_written(write_settings, terminal)
        return
    if path is None:
        raise typer.BadParameter("PATH is missing")
    chosen = given_settings(
        settings,
        frames={"start": start, "stop": stop, "stride": stride, "every": every, "frame_rate": frame_rate},
        calibration={"metres_per_pixel": metres_per_pixel, "lens": lens},
        region=region,
        soil={"kind": soil, "masks": masks},
        camera={"motion": camera, "vertical": vertical},
    )
    _analyze(path, method, out, chosen, Work(device, threads, processes), terminal)


def _analyze(
    path: Path,
    method: list[str] | None,
    out: Path | None,
    settings: Any,
    work: "Work",
    terminal: Terminal,
) -> None:
    from validation import chain
    from validation.methods import choose

    with terminal.working(), methods_of_this_folder():
        methods = choose(method or [settings.flow.method])
        with opened_material(path, out, settings) as (run, material):
            for one in methods:
                chain.analyze(run, material, one, settings=settings, work=work, terminal=terminal)
            if not material.has_truth:
                chain.draw(run, material, methods, terminal=terminal)
            document = step_document(run, *(f"analyze {one.slug}" for one in methods))
    terminal.show("\n".join(str(run.analysis(one.slug)) for one in methods))
    if not material.has_truth:
        terminal.show(f"figures: {run.figures}")
    terminal.give(document)


@app.command()
def score(
    path: Annotated[Path, typer.Argument(metavar="OUT", help="A run folder, or a footage folder.")],
    method: Methods = None,
    out: Out = None,
    threads: Threads = None,
    processes: Processes = 1,
    device: Device = "cpu",
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Compare soil flow with the truth: scores.json and report.html.

    Scores the methods that have been analyzed, or those asked for, which are analyzed first where needed.
    """
    from validation import chain
    from validation.methods import choose

    terminal = Terminal(json=json)
    with terminal.working(), methods_of_this_folder(), opened_material(path, out) as (run, material):
        work = chain.Work(device, threads, processes)
        methods = chain.methods_to_score(run, material, choose(method or []), work=work, terminal=terminal)
        scores = chain.score(run, material, methods, terminal=terminal)
        chain.report(run, material, methods, terminal=terminal)
    show_scores(run, scores, terminal)


@app.command()
def run(
    scene: SceneName,
    out: OutFolder,
    method: Methods = None,
    quick: Quick = False,
    seed: Seed = None,
    resume: Resume = True,
    overwrite: Overwrite = False,
    threads: Threads = None,
    processes: Processes = 1,
    device: Device = "cpu",
    json: Json = False,
    debug: Debug = False,
) -> None:
    """All of it: simulate, render, analyze, score, report. Run again, it does only what is missing."""
    from synth import load_scene
    from validation import chain
    from validation.methods import DEFAULT, choose
    from validation.run_folder import RunFolder

    terminal = Terminal(json=json)
    work = chain.Work(device, threads, processes)
    with terminal.working(), methods_of_this_folder():
        methods = choose(method or [DEFAULT])
        chain.require_methods(methods)
        chosen = load_scene(scene, quick=quick, seed=seed)
        with RunFolder.create(out) as folder:
            chain.simulate(folder, chosen, work=work, terminal=terminal, resume=resume, overwrite=overwrite)
            chain.render(folder, work=work, terminal=terminal)
            material = chain.footage_of(folder)
            for one in methods:
                chain.analyze(folder, material, one, work=work, terminal=terminal)
            scores = chain.score(folder, material, methods, terminal=terminal)
            chain.report(folder, material, methods, terminal=terminal)
    show_scores(folder, scores, terminal)
