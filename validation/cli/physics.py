"""Commands that hold the simulator to what is known: verify, calibrate."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from validation.cli.app import CHECK_FAILED, app
from validation.cli.options import Debug, Device, Json, Threads
from validation.terminal import Terminal


@app.command()
def verify(
    name: Annotated[
        Literal["dem"], typer.Argument(metavar="NAME", help="dem: the grain solver, discs and spheres.")
    ],
    case: Annotated[
        list[str] | None,
        typer.Option(
            "--case",
            metavar="CASE",
            help="Only this one; may repeat. One that is not there names them all.",
            show_default=False,
        ),
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Only the cases that take seconds.")] = False,
    threads: Threads = None,
    device: Device = "cpu",
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Hold the solver against closed forms and published numbers; exit status 1 where a limit is not kept."""
    from synth.devices import start_taichi
    from validation.verification.suite import choose_cases, verify_dem, verify_document, verify_table

    terminal = Terminal(json=json)
    with terminal.working():
        cases = choose_cases(case or [], quick=quick)
        start_taichi(device, threads)
        with terminal.progress(f"verify {name}") as progress:
            results = verify_dem(cases, progress=progress)
    terminal.show(verify_table(results))
    terminal.give(verify_document(results))
    if not all(result.passed for result in results):
        raise typer.Exit(CHECK_FAILED)


@app.command()
def calibrate(
    soil: Annotated[str, typer.Argument(metavar="SOIL", help="A shipped soil's name or a soil's TOML file.")],
    output: Annotated[Path, typer.Option("--output", metavar="FILE", help="The soil's TOML file to write.")],
    friction_angle: Annotated[
        float | None,
        typer.Option(min=1, max=60, metavar="DEG", help="Peak.", show_default="the soil's published one"),
    ] = None,
    relative_density: Annotated[
        float | None, typer.Option(min=0, max=1, show_default="that of the soil's bulk density")
    ] = None,
    seeds: Annotated[int, typer.Option(min=2, metavar="N", help="Samples of each biaxial test.")] = 8,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace FILE and its figure.")] = False,
    threads: Annotated[int, typer.Option(min=1, help="Samples are small: more is seldom faster.")] = 1,
    device: Device = "cpu",
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Find the grains' rolling friction that gives a soil's friction angle: FILE, and a figure beside it."""
    from validation.calibration.command import calibrate_file
    from validation.calibration.evidence import calibration_document, calibration_lines

    terminal = Terminal(json=json)
    with terminal.working():
        calibration, figure = calibrate_file(
            soil,
            output,
            friction_angle=friction_angle,
            relative_density=relative_density,
            seed_count=seeds,
            overwrite=overwrite,
            threads=threads,
            device=device,
            terminal=terminal,
        )
    terminal.show(f"{calibration_lines(calibration)}\n{output}, {figure}")
    files = {"file": str(output), "figure": str(figure)}
    terminal.give(calibration_document(calibration) | files)
