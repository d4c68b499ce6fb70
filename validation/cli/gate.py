"""Commands that guard a method against getting worse: gate, clip."""

from pathlib import Path
from typing import Annotated, Any

import typer

from validation.cli.app import CHECK_FAILED, app
from validation.cli.folders import methods_of_this_folder
from validation.cli.options import BUILT_IN_METHODS, Debug, Device, Json, Threads
from validation.terminal import Terminal


@app.command()
def gate(
    baseline: Annotated[
        Path, typer.Option("--baseline", metavar="FILE", help="What the method is held against, JSON.")
    ],
    method: Annotated[
        str,
        typer.Option(metavar="METHOD", help=f"{BUILT_IN_METHODS} or package.module:function."),
    ] = "robust-affine",
    clips: Annotated[
        Path | None,
        typer.Option(
            "--clips", metavar="DIR", help="Footage folders of your own.", show_default="those shipped"
        ),
    ] = None,
    update: Annotated[
        bool, typer.Option("--update", help="Write the baseline; what changed is still told.")
    ] = False,
    threads: Threads = None,
    device: Device = "cpu",
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Fail when a method got worse than its baseline in any stratum; no simulation, under a minute.

    Exit status 1 says which stratum got worse, and by how much.
    """
    from validation.gate.measurement import SHIPPED_CLIPS, Measurement, measure
    from validation.gate.verdict import compare, document

    terminal = Terminal(json=json)
    with terminal.working(), methods_of_this_folder():
        before = None if update and not baseline.is_file() else Measurement.read(baseline)
        with terminal.progress(f"gate {method}") as progress:
            after = measure(method, clips or SHIPPED_CLIPS, threads=threads, device=device, progress=progress)
        same_clips = before is not None and before.clips_digest == after.clips_digest
        rows = compare(before, after) if before and (same_clips or not update) else []
        if update:
            after.write(baseline)
    _show(rows, baseline, update=update, terminal=terminal)
    terminal.give(document(before or after, rows, after))
    if any(row.worse for row in rows) and not update:
        raise typer.Exit(CHECK_FAILED)


def _show(rows: list[Any], baseline: Path, *, update: bool, terminal: Terminal) -> None:
    from validation.gate.table import gate_table, verdict_line

    if rows:
        terminal.show(gate_table(rows))
        terminal.show(verdict_line(rows))
    if update:
        terminal.show(f"{baseline}: written")


@app.command()
def clip(
    footage: Annotated[Path, typer.Argument(metavar="FOOTAGE", help="A footage folder, or a run folder.")],
    out: Annotated[Path, typer.Argument(metavar="OUT", help="The footage folder to write.")],
    frames: Annotated[str, typer.Option(metavar="FIRST:LAST", help="Frames to keep, both ends included.")],
    crop: Annotated[str, typer.Option(metavar="X,Y,W,H", help="What of every picture, px.")],
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Cut a window and some frames out of footage, with the truth: small enough to be kept with code."""
    from soft import Region
    from synth import Footage
    from validation.clip import clip_footage, parse_frames

    terminal = Terminal(json=json)
    with terminal.working():
        (first, last), region = parse_frames(frames), Region.parse(crop, name="--crop")
        folder = footage / "footage" if (footage / "footage").is_dir() else footage
        with Footage.open(folder) as source:
            clip_footage(source, out, region=region, first=first, last=last)
    terminal.show(str(out))
    terminal.give({"schema_version": 1, "footage": str(out)})
