"""The command that measures speed."""

import os
from pathlib import Path
from typing import Annotated, Literal

import typer

from validation.cli.app import app
from validation.cli.options import Debug, Json, Threads
from validation.terminal import Terminal

_FOR = {
    "grains": ("dem",),
    "run": ("flow",),
    "openpiv": ("flow",),
    "pyvale": ("flow",),
    "photograph": ("flow",),
    "limits": ("flow",),
    "threads": ("dem", "render", "flow"),
}
"""Which benches an option is for; the others of `bench` are for all."""


@app.command()
def bench(
    context: typer.Context,
    name: Annotated[
        Literal["dem", "render", "flow", "sweep"],
        typer.Argument(
            metavar="NAME",
            help="dem: the grain solver, LAMMPS. render: pictures with truth. flow: methods' errors, speed. "
            "sweep: sequences of a data set, by one worker and by two.",
        ),
    ],
    grains: Annotated[
        list[int] | None,
        typer.Option(min=100, metavar="N", help="dem: about so many discs; may repeat.", show_default=False),
    ] = None,
    run: Annotated[
        list[Path] | None,
        typer.Option(metavar="OUT", help="flow: a run's folder, scored too; may repeat.", show_default=False),
    ] = None,
    openpiv: Annotated[
        str | None,
        typer.Option(
            metavar="PYTHON",
            envvar="SOFTBED_OPENPIV",
            help="flow: the interpreter of an environment that has OpenPIV.",
            show_default=False,
        ),
    ] = None,
    pyvale: Annotated[
        str | None,
        typer.Option(
            metavar="PYTHON",
            envvar="SOFTBED_PYVALE",
            help="flow: the interpreter of an environment that has pyvale.",
            show_default=False,
        ),
    ] = None,
    photograph: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="flow: a photograph of soil, to be moved by formulas; else one in $SOFTBED_DATA.",
            show_default=False,
        ),
    ] = None,
    limits: Annotated[
        bool,
        typer.Option(
            "--limits", help="flow: also what no method can do better: Cramér-Rao bounds, floors of runs."
        ),
    ] = False,
    repeats: Annotated[int, typer.Option(min=1, help="Measurements; their median is told.")] = 5,
    threads: Threads = None,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Measure speed, ours and that of peers found on the PATH, on the same work and in turn."""
    refuse_foreign_options(context, name)
    from validation.bench.dem import GRAIN_COUNTS, bench_dem
    from validation.bench.flow import bench_flow
    from validation.bench.flow_case import analytic_cases, run_cases
    from validation.bench.flow_contender import CONTENDERS, Subject
    from validation.bench.limits import bench_limits
    from validation.bench.openpiv import OpenPiv
    from validation.bench.photograph import photograph_cases
    from validation.bench.render import bench_render
    from validation.bench.rows import bench_document, bench_table
    from validation.bench.subset_dic import SubsetDic
    from validation.bench.sweep import WORKERS, bench_sweep

    terminal = Terminal(json=json)
    workers = max(WORKERS) if name == "sweep" else threads or os.cpu_count() or 1
    with terminal.working(), terminal.progress(f"bench {name}") as progress:
        if name == "flow":
            cases = analytic_cases() + photograph_cases(photograph) + run_cases(run or ())
            subjects: list[Subject] = [*CONTENDERS, OpenPiv(openpiv), SubsetDic(pyvale)]
            rows = bench_flow(cases, subjects=subjects, repeats=repeats, threads=workers, progress=progress)
            rows += bench_limits(rows, run or (), threads=workers, progress=progress) if limits else []
        elif name == "render":
            rows = bench_render(repeats=repeats, threads=workers, progress=progress)
        elif name == "sweep":
            rows = bench_sweep(repeats=repeats, progress=progress)
        else:
            rows = bench_dem(
                grain_counts=grains or GRAIN_COUNTS, repeats=repeats, threads=workers, progress=progress
            )
    terminal.show(bench_table(f"bench {name}, {workers} threads", rows))
    terminal.give(bench_document(name, rows, threads=workers, device="cpu"))


def refuse_foreign_options(context: typer.Context, name: str) -> None:
    """Refuse what another bench takes; environment variables may be there for all."""
    for option, benches in _FOR.items():
        source = context.get_parameter_source(option)
        if name not in benches and source is not None and source.name == "COMMANDLINE":
            raise typer.BadParameter(f"--{option}: bench {name} takes none: only for {', '.join(benches)}")
