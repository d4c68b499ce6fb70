"""Scores as a table on a terminal."""

from typing import TYPE_CHECKING

from validation.published import read_published
from validation.scoring.metrics import WRONG_ABOVE

if TYPE_CHECKING:
    from rich.table import Table

    from validation.run_folder import RunFolder
    from validation.scoring.metrics import ErrorSummary
    from validation.scoring.regions import RegionScore
    from validation.scoring.score import Scores

ROTATION = "plate_rotation"
REGION_COLUMNS = (
    "soil IoU",
    "moving IoU",
    "interface in pairs",
    "to the true one px",
    "both ways px",
    "by the true camera px",
    "from greatest shear px",
    "true one from it px",
)
"""The last five hold mean and 95 %."""


def score_table(scores: "Scores") -> "Table":
    """One line for each method and its time, below it one for each stratum that has pixels.

    Narrow enough for a terminal of 80 columns.
    """
    table = _plain_table(_title(scores))
    table.add_column("method, strata", overflow="fold")
    for column in ("pixels", "measured", "median", "95 %", *(f"> {bound}" for bound in WRONG_ABOVE)):
        table.add_column(column, justify="right", no_wrap=True)
    for name, method in scores.methods.items():
        table.add_row(name, f"{number(method.seconds_per_pair, '.2f')} s/pair")
        for stratum, summary in method.strata.items():
            if summary.pixel_count:
                table.add_row(f"  {stratum}", *cells(summary))
        table.add_section()
    return table


def camera_lines(scores: "Scores") -> list[str]:
    """Say how well each method found the camera's motion, one line each."""
    told = [(name, method.camera) for name, method in scores.methods.items() if method.camera is not None]
    return [f"camera, {name}: {camera}" for name, camera in told]


def region_table(scores: "Scores") -> "Table | None":
    """One column for each method whose regions were scored; None if there is none."""
    scored = {name: method.regions for name, method in scores.methods.items() if method.regions is not None}
    if not scored:
        return None
    table = _plain_table("soil, moving region, shear interface: of the distances mean / 95 %, in px")
    table.add_column("method")
    for name in scored:
        table.add_column(name, justify="right", overflow="fold")
    rows = zip(*(region_cells(regions) for regions in scored.values()), strict=True)
    for label, row in zip(REGION_COLUMNS, rows, strict=True):
        table.add_row(label.removesuffix(" px"), *row)
    return table


def region_cells(regions: "RegionScore") -> list[str]:
    """What stands in the columns of `REGION_COLUMNS`."""
    seen = regions.interface_pair_count + regions.interface_missed_count
    found = f"{regions.interface_pair_count} of {seen}" if seen else "none to find"
    if regions.interface_false_count:
        found += f", {regions.interface_false_count} false"
    return [
        number(regions.soil_iou, ".4f"),
        number(regions.moving_iou, ".3f"),
        found,
        *(
            f"{number(mean, '.1f')} / {number(p95, '.1f')}"
            for mean, p95 in (
                (regions.interface_mean, regions.interface_p95),
                (regions.interface_symmetric_mean, regions.interface_symmetric_p95),
                (regions.interface_true_camera_mean, regions.interface_true_camera_p95),
                (regions.shear_line_mean, regions.shear_line_p95),
                (regions.shear_line_true_mean, regions.shear_line_true_p95),
            )
        ),
    ]


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


def _plain_table(title: str) -> "Table":
    from rich import box
    from rich.table import Table

    return Table(
        title=title, title_justify="left", box=box.SIMPLE_HEAD, collapse_padding=True, pad_edge=False
    )


def _title(scores: "Scores") -> str:
    if not scores.scene:
        return "end-point error in px"
    quick = ", quick" if scores.quick else ""
    return f"end-point error in px, {scores.scene}, seed {scores.seed}{quick}"
