"""Commands that measure and score: analyze, score, run."""

from pathlib import Path
from typing import Annotated

import typer

from validation.cli.app import app
from validation.cli.folders import methods_of_this_folder, opened_material, show_scores, step_document
from validation.cli.options import (
    Debug,
    Device,
    FrameRate,
    Json,
    Methods,
    MetresPerPixel,
    Out,
    OutFolder,
    Overwrite,
    Quick,
    Resume,
    SceneName,
    Seed,
    Soil,
    Threads,
    Vertical,
)
from validation.terminal import Terminal


@app.command()
def analyze(
    path: Annotated[
        Path, typer.Argument(metavar="PATH", help="A run folder, a footage folder, or a folder of pictures.")
    ],
    method: Methods = None,
    out: Out = None,
    metres_per_pixel: MetresPerPixel = None,
    frame_rate: FrameRate = None,
    soil: Soil = "bright",
    vertical: Vertical = False,
    threads: Threads = None,
    device: Device = "cpu",
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Measure soil flow in pictures: analysis/METHOD.nc, and figures/ where no truth is known."""
    from validation import chain
    from validation.methods import DEFAULT, choose

    terminal = Terminal(json=json)
    with terminal.working(), methods_of_this_folder():
        methods = choose(method or [DEFAULT])
        scale = {"metres_per_pixel": metres_per_pixel, "frame_rate": frame_rate}
        with opened_material(path, out, **scale) as (run, material):
            for chosen in methods:
                work = chain.Work(device, threads)
                chain.analyze(
                    run, material, chosen, soil=soil, vertical=vertical, work=work, terminal=terminal
                )
            if not material.has_truth:
                chain.draw(run, material, methods, terminal=terminal)
            document = step_document(run, *(f"analyze {chosen.slug}" for chosen in methods))
    terminal.show("\n".join(str(run.analysis(chosen.slug)) for chosen in methods))
    if not material.has_truth:
        terminal.show(f"figures: {run.figures}")
    terminal.give(document)


@app.command()
def score(
    path: Annotated[Path, typer.Argument(metavar="OUT", help="A run folder, or a footage folder.")],
    method: Methods = None,
    out: Out = None,
    threads: Threads = None,
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
        work = chain.Work(device, threads)
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
    work = chain.Work(device, threads)
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
