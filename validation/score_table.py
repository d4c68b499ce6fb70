"""Scores as a table on a terminal."""

from typing import TYPE_CHECKING

from validation.metrics import WRONG_ABOVE
from validation.published import read_published

if TYPE_CHECKING:
    from rich.table import Table

    from validation.metrics import ErrorSummary
    from validation.run_folder import RunFolder
    from validation.score import Scores

ROTATION = "plate_rotation"


def score_table(scores: "Scores") -> "Table":
    """One line for each method and stratum that has pixels."""
    from rich.table import Table

    table = Table(title=_title(scores), title_justify="left")
    for column, justify in (
        ("method", "left"),
        ("stratum", "left"),
        ("pixels", "right"),
        ("measured", "right"),
    ):
        table.add_column(column, justify=justify, overflow="fold")  # type: ignore[arg-type]
    for column in ("median px", "95 % px", *(f"> {bound} px" for bound in WRONG_ABOVE), "s/pair"):
        table.add_column(column, justify="right")
    for name, method in scores.methods.items():
        shown = [(stratum, summary) for stratum, summary in method.strata.items() if summary.pixel_count]
        for row, (stratum, summary) in enumerate(shown):
            seconds = number(method.seconds_per_pair, ".2f") if row == 0 else ""
            table.add_row(name if row == 0 else "", stratum, *cells(summary), seconds)
        table.add_section()
    return table


def camera_lines(scores: "Scores") -> list[str]:
    """Say how well each method found the camera's motion, one line each."""
    told = [(name, method.camera) for name, method in scores.methods.items() if method.camera is not None]
    return [f"camera, {name}: {camera}" for name, camera in told]


def cells(summary: "ErrorSummary") -> list[str]:
    """Pixels, measured share, median, 95 %, and the wrong shares of one stratum."""
    return [
        f"{summary.pixel_count:,}".replace(",", "\N{NARROW NO-BREAK SPACE}"),
        number(summary.coverage, ".1%"),
        number(summary.median, ".3f"),
        number(summary.p95, ".3f"),
        *(number(summary.wrong_share[str(bound)], ".1%") for bound in WRONG_ABOVE),
    ]


def number(value: float | None, form: str) -> str:
    """Write a number in the form asked for, a dash where there is none."""
    return "-" if value is None else format(value, form)


def published_lines(run: "RunFolder") -> list[str]:
    """Say what was published about this experiment, one line each."""
    if not is_published_rotation(run):
        return []
    rows = read_published("rotation")
    median, p95 = rows["median"], rows["p95"]
    errors = f"median {median.value:.2f} px, 95 % {p95.value:.2f} px"
    return [f"published (Skonieczny et al. 2014, {median.where}): {errors}"]


def is_published_rotation(run: "RunFolder") -> bool:
    """Whether the run is of the controlled rotation test."""
    if not run.scene.is_file():
        return False
    from synth import load_scene

    return load_scene(run.scene).kind == ROTATION


def _title(scores: "Scores") -> str:
    if not scores.scene:
        return "end-point error"
    quick = ", quick" if scores.quick else ""
    return f"end-point error, {scores.scene}, seed {scores.seed}{quick}"
