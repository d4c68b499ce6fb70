"""The command line: `softbed`.

Heavy libraries are imported inside commands, so that `softbed --help` is instant.
"""

import os
import sys
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from validation.studies import STUDIES, find_study
from validation.terminal import Terminal

CHECK_FAILED = 1
BAD_INPUT = 2
FAULT = 70
"""Exit status of a fault of this program itself; 1 is kept for checks that fail."""
INTERRUPTED = 130
_ROOMS = ("soft", "synth", "validation")

app = typer.Typer(
    help="A virtual glass-walled soil bin where every grain's motion is known, soil optical flow, its score.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
)

SceneName = Annotated[str, typer.Argument(metavar="SCENE", help="A shipped scene's name or a TOML file.")]
OutFolder = Annotated[Path, typer.Argument(metavar="OUT", help="A run folder; made where there is none.")]
RunPath = Annotated[Path, typer.Argument(metavar="OUT", help="A run folder.")]
Quick = Annotated[bool, typer.Option("--quick", help="The scene's smaller and coarser version.")]
Seed = Annotated[int | None, typer.Option(min=0, metavar="N", help="Another realisation.")]
Threads = Annotated[int | None, typer.Option(min=1, help="Default: every core.", show_default=False)]
Resume = Annotated[
    bool, typer.Option("--resume/--no-resume", help="Go on where a killed simulation left a checkpoint.")
]
Overwrite = Annotated[
    bool, typer.Option("--overwrite", help="Replace another scene's or seed's run that OUT holds.")
]
Device = Annotated[Literal["cpu", "cuda"], typer.Option(help="Where kernels run.")]
Methods = Annotated[
    list[str] | None,
    typer.Option(
        "--method",
        metavar="METHOD",
        help="robust-affine, dis, farneback, tvl1, ilk, package.module:function or files:FOLDER; may repeat.",
        show_default=False,
    ),
]
Out = Annotated[
    Path | None,
    typer.Option("--out", metavar="DIR", help="Default: PATH if it is a run folder, else ./<name>-softbed."),
]
MetresPerPixel = Annotated[
    float | None, typer.Option(help="Size of a pixel on the glass, m.", show_default=False)
]
FrameRate = Annotated[float | None, typer.Option(help="Pictures a second.", show_default=False)]
Soil = Annotated[
    Literal["bright", "dark", "all"],
    typer.Option(help="Soil against what surrounds it; all: only soil."),
]
Vertical = Annotated[
    bool, typer.Option("--vertical", help="Take the camera's vertical motion out, too (handheld, settling).")
]
Json = Annotated[bool, typer.Option("--json", help="One JSON document on standard output and nothing else.")]
Debug = Annotated[bool, typer.Option("--debug", help="A full traceback when something fails.")]


def main() -> None:
    """Run the command line; the process ends with 0 done, 1 a check failed, 2 bad input or usage."""
    sys.exit(run_command(sys.argv[1:]))


def run_command(arguments: Sequence[str]) -> int:
    """Run one command and return its exit status; every expected error is one line on standard error."""
    os.environ.setdefault("OPENCV_LOG_LEVEL", "SILENT")  # what it warns of is said by our own line
    try:
        status = app(args=list(arguments), prog_name="softbed", standalone_mode=False)
    except KeyboardInterrupt:
        status = INTERRUPTED
    except Exception as error:
        if "--debug" in arguments or not _is_expected(error):
            traceback.print_exc()
            return BAD_INPUT if _is_expected(error) else FAULT
        _complain(_in_one_line(error), as_json="--json" in arguments)
        return BAD_INPUT
    if status == INTERRUPTED:
        _complain("interrupted; nothing half-written is left, the same command goes on", as_json=False)
    return status if isinstance(status, int) else 0


def _is_expected(error: Exception) -> bool:
    """Bad input and usage, as against faults of this program."""
    ours = type(error).__module__.partition(".")[0] in _ROOMS
    return ours or isinstance(error, ValueError | OSError) or _is_usage_error(error)


def _is_usage_error(error: Exception) -> bool:
    # Which module defines it depends on typer's version; all of them can word themselves.
    return hasattr(error, "format_message")


def _in_one_line(error: Exception) -> str:
    if _is_usage_error(error):
        command = getattr(getattr(error, "ctx", None), "command_path", "softbed")
        text = f"{error.format_message()} (see {command} --help)"  # type: ignore[attr-defined]
    elif isinstance(error, OSError) and error.strerror:
        text = f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    else:
        text = str(error) or type(error).__name__
    return " ".join(text.split())


def _complain(line: str, *, as_json: bool) -> None:
    terminal = Terminal(json=as_json)
    terminal.say(f"softbed: {line}")
    terminal.give({"schema_version": 1, "error": line})


def _version(wanted: bool) -> None:
    if wanted:
        from validation.versions import package_version

        print(f"softbed {package_version('softbed')}")  # noqa: T201
        raise typer.Exit


@app.callback()
def _every_command(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Say the version and end.")
    ] = False,
) -> None:
    pass


@app.command()
def scenes(json: Json = False, debug: Debug = False) -> None:
    """List the shipped scenes."""
    from synth import load_scene, scene_names

    terminal = Terminal(json=json)
    with terminal.working():
        shipped = [load_scene(name) for name in scene_names()]
    widest = max(len(scene.name) for scene in shipped)
    terminal.show("\n".join(f"{scene.name:{widest}}  {scene.description}" for scene in shipped))
    rows = [{"name": scene.name, "kind": scene.kind, "description": scene.description} for scene in shipped]
    terminal.give({"schema_version": 1, "scenes": rows})


@app.command("new-scene")
def new_scene(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The TOML file to write; must not exist.")],
    source: Annotated[
        str, typer.Option("--from", metavar="SCENE", help="The shipped scene to start from.")
    ] = "rolling_wheel",
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Write a commented scene file to change and run."""
    from validation.scene_template import write_template

    terminal = Terminal(json=json)
    with terminal.working():
        write_template(file, source)
    terminal.show(f"{file}: written; change it, then: softbed run {file} OUT")
    terminal.give({"schema_version": 1, "file": str(file), "from": source})


@app.command()
def simulate(
    scene: SceneName,
    out: OutFolder,
    quick: Quick = False,
    seed: Seed = None,
    resume: Resume = True,
    overwrite: Overwrite = False,
    convergence: Annotated[
        bool,
        typer.Option(
            "--convergence",
            help="Also at half speed-up, doubled box, halved step, another seed: OUT/convergence.",
        ),
    ] = False,
    threads: Threads = None,
    device: Device = "cpu",
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Simulate a scene: OUT/recording.nc and OUT/forces.csv."""
    from synth import load_scene
    from validation import chain
    from validation.run_folder import RunFolder

    terminal = Terminal(json=json)
    with terminal.working():
        chosen = load_scene(scene, quick=quick, seed=seed)
        with RunFolder.create(out) as run:
            work = chain.Work(device, threads)
            chain.simulate(run, chosen, work=work, terminal=terminal, resume=resume, overwrite=overwrite)
            document = _step_document(run, "simulate")
        if convergence:
            from validation.studies.convergence import BASE

            place = out / "convergence"
            document["convergence"] = _carry_out(
                "convergence",
                chosen,
                place,
                quick=quick,
                given={BASE: out},
                resume=resume,
                overwrite=overwrite,
                work=work,
                terminal=terminal,
            )
    terminal.show(f"{run.recording}, {run.forces}")
    if convergence:
        _show_study(document["convergence"], place, terminal)
    terminal.give(document)


@app.command()
def render(
    out: RunPath,
    threads: Threads = None,
    device: Device = "cpu",
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Render the pictures of a simulated run, and the truth about them: OUT/footage."""
    from validation import chain
    from validation.run_folder import RunFolder

    terminal = Terminal(json=json)
    with terminal.working(), RunFolder.open(out) as run:
        chain.render(run, work=chain.Work(device, threads), terminal=terminal)
        document = _step_document(run, "render")
    terminal.show(str(run.footage))
    terminal.give(document)


@app.command()
def export(
    path: Annotated[Path, typer.Argument(metavar="OUT", help="A run folder, or a footage folder.")],
    file_format: Annotated[
        Literal["vtk", "flo", "kitti", "netcdf", "csv", "mp4"],
        typer.Option(
            "--format",
            help="vtk: grains, implement and contacts for ParaView. The others: truth and measured motion; "
            "kitti rounds to 1/64 px, mp4 is for looking at only.",
        ),
    ] = "vtk",
    out: Out = None,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Write what was simulated or measured in a format of other programs: OUT/FORMAT."""
    from validation import chain
    from validation.run_folder import RunFolder

    terminal = Terminal(json=json)
    with terminal.working():
        if file_format == "vtk":
            with RunFolder.open(path) as run:
                chain.export_vtk(run, terminal=terminal)
        else:
            with _material(path, out) as (run, material):
                chain.export_fields(run, material, file_format, terminal=terminal)
        document = _step_document(run, f"export {file_format}")
    terminal.show(_exported(run.path / file_format))
    terminal.give(document)


def _exported(folder: Path) -> str:
    """Name what lies in a folder, to open first."""
    series = sorted(folder.glob("*.pvd"))
    return ", ".join(map(str, series or sorted(folder.iterdir())))


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
    with terminal.working(), _methods_of_this_folder():
        methods = choose(method or [DEFAULT])
        scale = {"metres_per_pixel": metres_per_pixel, "frame_rate": frame_rate}
        with _material(path, out, **scale) as (run, material):
            for chosen in methods:
                work = chain.Work(device, threads)
                chain.analyze(
                    run, material, chosen, soil=soil, vertical=vertical, work=work, terminal=terminal
                )
            if not material.has_truth:
                chain.draw(run, material, methods, terminal=terminal)
            document = _step_document(run, *(f"analyze {chosen.slug}" for chosen in methods))
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
    with terminal.working(), _methods_of_this_folder(), _material(path, out) as (run, material):
        work = chain.Work(device, threads)
        methods = chain.methods_to_score(run, material, choose(method or []), work=work, terminal=terminal)
        scores = chain.score(run, material, methods, terminal=terminal)
        chain.report(run, material, methods, terminal=terminal)
    _show_scores(run, scores, terminal)


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
    with terminal.working(), _methods_of_this_folder():
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
    _show_scores(folder, scores, terminal)


@app.command()
def check(
    path: Annotated[Path, typer.Argument(metavar="OUT", help="A run folder, or a footage folder.")],
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Verify hashes and form of every file, and name what is wrong; exit status 1 where something is."""
    from validation.check import check_folder

    terminal = Terminal(json=json)
    with terminal.working(), terminal.progress("check") as progress:
        findings = check_folder(path, progress=progress)
    terminal.show(str(findings))
    terminal.give(findings.to_dict())
    if findings.faults:
        raise typer.Exit(CHECK_FAILED)


@app.command("compare-pictures")
def compare_pictures(
    a: Annotated[Path, typer.Argument(metavar="A", help="A picture, or a folder of pictures.")],
    b: Annotated[Path, typer.Argument(metavar="B", help="What to set beside it.")],
    crop_a: Annotated[
        str | None, typer.Option(metavar="X,Y,W,H", help="Only this part of A, px.", show_default=False)
    ] = None,
    crop_b: Annotated[
        str | None, typer.Option(metavar="X,Y,W,H", help="Only this part of B, px.", show_default=False)
    ] = None,
    bin_a: Annotated[int, typer.Option(min=1, max=64, metavar="N", help="Make N x N px of A one.")] = 1,
    bin_b: Annotated[int, typer.Option(min=1, max=64, metavar="N", help="Make N x N px of B one.")] = 1,
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="The figure to write, a PNG.")] = Path(
        "compare-pictures.png"
    ),
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Set grey levels, grain size, spectrum, gradient and noise of pictures side by side."""
    from validation import compare_pictures as compare
    from validation.figures import to_png

    terminal = Terminal(json=json)
    with terminal.working():
        crops = [None if text is None else compare.Crop.parse(text) for text in (crop_a, crop_b)]
        first, second = (
            compare.picture_statistics(compare.read_pictures(path, crop, binning=side), path.name)
            for path, crop, side in zip((a, b), crops, (bin_a, bin_b), strict=True)
        )
        out.write_bytes(to_png(compare.draw_comparison(first, second)))
    terminal.show("\n".join([*compare.comparison_lines(first, second), f"figure: {out}"]))
    terminal.give(compare.comparison_document(first, second, out))


@app.command("contact-sheet")
def contact_sheet(
    out: Annotated[Path, typer.Argument(metavar="OUT", help="A folder; every run is in OUT/runs.")],
    scene: Annotated[
        list[str] | None,
        typer.Option("--scene", metavar="SCENE", help="Only this one; may repeat.", show_default=False),
    ] = None,
    run: Annotated[
        list[Path] | None,
        typer.Option(
            "--run",
            metavar="OUT",
            help="A run folder elsewhere, quick, whose recording stands for its scene; may repeat.",
            show_default=False,
        ),
    ] = None,
    resume: Resume = True,
    threads: Threads = None,
    device: Device = "cpu",
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Lay out a picture of every shipped scene, clean and disturbed: OUT/contact-sheet.jpg.

    Scenes are simulated in their quick versions. Called again, it does only what is missing.
    """
    from synth import scene_names
    from validation import chain
    from validation.contact_sheet import make_contact_sheet
    from validation.manifest import Manifest

    terminal = Terminal(json=json)
    with terminal.working():
        names = scene or [*scene_names()]
        given = {Manifest.read(path).scene: path for path in run or []}
        work = chain.Work(device, threads)
        sheet = make_contact_sheet(out, names, given=given, resume=resume, work=work, terminal=terminal)
    terminal.show(str(sheet))
    terminal.give({"schema_version": 1, "sheet": str(sheet), "scenes": names})


@app.command()
def verify(
    name: Annotated[Literal["dem"], typer.Argument(metavar="NAME", help="dem: the grain solver.")],
    case: Annotated[
        list[str] | None,
        typer.Option("--case", metavar="CASE", help="Only this one; may repeat.", show_default=False),
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


@app.command()
def bench(
    name: Annotated[
        Literal["dem", "render", "flow"],
        typer.Argument(
            metavar="NAME",
            help="dem: the grain solver, LAMMPS. render: pictures with truth. flow: methods' errors, speed.",
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
    from validation.bench.dem import GRAIN_COUNTS, bench_dem
    from validation.bench.flow import bench_flow
    from validation.bench.flow_case import analytic_cases, run_cases
    from validation.bench.flow_contender import Subject, contenders
    from validation.bench.limits import bench_limits
    from validation.bench.openpiv import OpenPiv
    from validation.bench.photograph import photograph_cases
    from validation.bench.render import bench_render
    from validation.bench.rows import bench_document, bench_table
    from validation.bench.subset_dic import SubsetDic

    terminal = Terminal(json=json)
    workers = threads or os.cpu_count() or 1
    with terminal.working(), terminal.progress(f"bench {name}") as progress:
        if name == "flow":
            cases = analytic_cases() + photograph_cases(photograph) + run_cases(run or ())
            subjects: list[Subject] = [*contenders(), OpenPiv(openpiv), SubsetDic(pyvale)]
            rows = bench_flow(cases, subjects=subjects, repeats=repeats, threads=workers, progress=progress)
            rows += bench_limits(rows, run or (), threads=workers, progress=progress) if limits else []
        elif name == "render":
            rows = bench_render(repeats=repeats, threads=workers, progress=progress)
        else:
            rows = bench_dem(
                grain_counts=grains or GRAIN_COUNTS, repeats=repeats, threads=workers, progress=progress
            )
    terminal.show(bench_table(f"bench {name}, {workers} threads", rows))
    terminal.give(bench_document(name, rows, threads=workers, device="cpu"))


@app.command()
def study(
    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME", help="; ".join(f"[b]{name}[/b]: {about}" for name, about in STUDIES.items())
        ),
    ],
    out: Annotated[Path, typer.Argument(metavar="OUT", help="The study's folder; every run is in OUT/runs.")],
    scene: Annotated[
        str | None,
        typer.Option("--scene", metavar="SCENE", help="Start from this scene.", show_default=False),
    ] = None,
    quick: Quick = False,
    seed: Seed = None,
    resume: Resume = True,
    overwrite: Overwrite = False,
    threads: Threads = None,
    device: Device = "cpu",
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Run a scene several times with something changed: OUT/NAME.csv, NAME.png and a line of conclusion.

    Carried out again, it does only what is missing.
    """
    from synth import load_scene
    from validation import chain

    terminal = Terminal(json=json)
    with terminal.working():
        chosen = load_scene(scene or find_study(name).scene, quick=quick, seed=seed)
        work = chain.Work(device, threads)
        options = {"quick": quick, "resume": resume, "overwrite": overwrite}
        document = _carry_out(name, chosen, out, **options, work=work, terminal=terminal)
    _show_study(document, out, terminal)
    terminal.give(document)


def _carry_out(name: str, *arguments: Any, **options: Any) -> dict[str, Any]:
    from validation.studies.carry_out import carry_out

    return carry_out(name, find_study(name), *arguments, **options)


def _show_study(document: dict[str, Any], out: Path, terminal: Terminal) -> None:
    from validation.studies.carry_out import study_table

    terminal.show(study_table(document))
    terminal.show(document["conclusion"])
    terminal.show(f"{out / document['study']}.csv, .png, .json")


@contextmanager
def _material(path: Path, out: Path | None, **scale: float | None) -> Iterator[tuple[Any, Any]]:
    """Open the folder that results go to, and the pictures."""
    from validation import chain
    from validation.material import Material, results_folder
    from validation.run_folder import RunFolder, is_run_folder

    chosen = results_folder(path, out)
    if chosen != path and (chosen / "recording.nc").is_file():
        raise typer.BadParameter(f"--out: {chosen} is the run folder of a simulation, not for other pictures")
    if is_run_folder(path):
        _refuse_scale(path, scale)
        with RunFolder.open(path) as source:
            material = chain.footage_of(source)
            if chosen == path:
                yield source, material
                return
            with RunFolder.create(chosen) as results:
                yield results, material
        return
    material = Material.open(path, **scale)
    with RunFolder.create(chosen) as results:
        yield results, material


def _refuse_scale(path: Path, scale: dict[str, float | None]) -> None:
    given = [name for name, value in scale.items() if value is not None]
    if given:
        option = f"--{given[0].replace('_', '-')}"
        raise typer.BadParameter(f"{option}: {path} is a run folder, whose footage knows its own")


@contextmanager
def _methods_of_this_folder() -> Iterator[None]:
    """Let a user's own `package.module:function` lie in the current folder."""
    here = str(Path.cwd())
    sys.path.insert(0, here)
    try:
        yield
    finally:
        sys.path.remove(here)


def _step_document(run: Any, *steps: str) -> dict[str, Any]:
    done = {step: run.manifest.steps[step] for step in steps}
    return {
        "schema_version": 1,
        "folder": str(run.path),
        "steps": {
            step: {"seconds": record.seconds, "files": record.files, **record.facts}
            for step, record in done.items()
        },
    }


def _show_scores(run: Any, scores: Any, terminal: Terminal) -> None:
    from validation.score_table import published_lines, score_table

    terminal.show(score_table(scores))
    for line in published_lines(run):
        terminal.show(line)
    terminal.show(f"scores: {run.scores}\nreport: {run.report}")
    terminal.give(scores.to_dict())
