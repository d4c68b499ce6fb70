"""Commands that show what was measured: figure, film."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from synth.disk import written_whole
from validation.cli.app import app
from validation.cli.folders import opened_material
from validation.cli.options import Debug, Json
from validation.showing.kinds import KINDS
from validation.terminal import Terminal

if TYPE_CHECKING:
    from validation.showing.subject import Subject

ShownPath = Annotated[
    Path, typer.Argument(metavar="PATH", help="A run folder, or pictures that have been analyzed.")
]
ShownMethod = Annotated[
    str | None,
    typer.Option("--method", metavar="METHOD", help="Default: robust-affine, or the first there is."),
]
Results = Annotated[
    Path | None,
    typer.Option(
        "--results",
        metavar="DIR",
        help="Where PATH was analyzed to. Default: as for analyze.",
        show_default=False,
    ),
]
ColourChoice = Annotated[
    Literal["even", "paper"], typer.Option(help="Even steps that all can tell apart, or the paper's look.")
]


@app.command()
def figure(
    kind: Annotated[
        str,
        typer.Argument(
            metavar="KIND", help="; ".join(f"[b]{name}[/b]: {kind.about}" for name, kind in KINDS.items())
        ),
    ],
    path: ShownPath,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE", help="PNG, PDF or SVG, by its suffix. Default: KIND.png."),
    ] = None,
    pair: Annotated[
        int | None,
        typer.Option(help="From 0; negative: from the end. Default: the middle.", show_default=False),
    ] = None,
    method: ShownMethod = None,
    beside: Annotated[
        Path | None,
        typer.Option("--with", metavar="PATH", help="What compare sets beside PATH.", show_default=False),
    ] = None,
    colours: ColourChoice = "even",
    results: Results = None,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Draw one figure of a measurement, in the manner of the paper."""
    from soft.figures.page import require_suffix, save_figure
    from validation.showing.kinds import Order, draw_figure, require_kind

    terminal = Terminal(json=json)
    require_kind(kind)
    file = out or Path(f"{kind}.png")
    require_suffix(file)
    with terminal.working(), _opened(path, results, method) as subject, _beside(beside, method) as other:
        chosen = subject.require_pair(pair)
        drawn = draw_figure(kind, Order(subject, chosen, colours, other))
        with written_whole(file) as draft:
            save_figure(drawn, draft)
    terminal.show(str(file))
    terminal.give({"schema_version": 1, "figure": kind, "file": str(file), "pair": chosen})


@app.command()
def film(
    path: ShownPath,
    out: Annotated[
        Path,
        typer.Option("--out", metavar="FILE", help="mp4 (VP9, which browsers play) or gif, by its suffix."),
    ] = Path("film.mp4"),
    method: ShownMethod = None,
    colours: ColourChoice = "even",
    results: Results = None,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Make a film of a measurement: picture, motion, and truth and error where the truth is known."""
    from soft.figures.film_file import FILM_SUFFIXES
    from soft.figures.page import require_suffix
    from validation.showing.film import film as make_film

    terminal = Terminal(json=json)
    require_suffix(out, FILM_SUFFIXES)
    with (
        terminal.working(),
        _opened(path, results, method) as subject,
        terminal.progress("film") as progress,
        written_whole(out) as draft,
    ):
        make_film(subject, draft, colours=colours, progress=progress)
    terminal.show(str(out))
    terminal.give({"schema_version": 1, "file": str(out), "pair_count": subject.pair_count})


@contextmanager
def _opened(path: Path, results: Path | None, method: str | None) -> "Iterator[Subject]":
    from validation.showing.subject import opened_subject

    with (
        opened_material(path, results) as (run, material),
        opened_subject(path, run, material, method=method) as subject,
    ):
        yield subject


@contextmanager
def _beside(path: Path | None, method: str | None) -> "Iterator[Subject | None]":
    if path is None:
        yield None
        return
    with _opened(path, None, method) as subject:
        yield subject
