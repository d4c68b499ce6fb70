"""The page a person reads: `report.html`, one file that needs nothing else."""

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.figures import (
    draw_direction,
    draw_error,
    draw_forces,
    draw_histogram,
    draw_picture,
    draw_speed,
    draw_strata,
)
from validation.page import Panel, write_page
from validation.pair_view import PairView, middle_pair, view_pair
from validation.published import Published, read_published
from validation.scoring.metrics import WRONG_ABOVE
from validation.scoring.score import Scores
from validation.scoring.score_table import REGION_COLUMNS, cells, is_published_rotation, number, region_cells
from validation.scoring.strata import MEANINGS
from validation.versions import machine, package_version, package_versions

if TYPE_CHECKING:
    from synth.dem.soundness import Judgement
    from validation.material import Material
    from validation.methods import Method
    from validation.run_folder import RunFolder

_TOP_PERCENTILE = 99.5


@dataclass(frozen=True)
class MethodPage:
    """What the page shows of one method."""

    name: str
    rows: list[tuple[str, list[str]]]
    seconds: str
    sentence: str
    panels: list[Panel] = field(default_factory=list)


def write_report(path: Path, run: "RunFolder", material: "Material", methods: "Sequence[Method]") -> None:
    """Write the report of a scored run.

    Parameters
    ----------
    path : Path
        The page to write.
    run : RunFolder
        Where scores and analyses are.
    material : Material
        The pictures, with their truth.
    methods : sequence of Method
        What was scored.
    """
    write_page(path, "report.html.j2", _content(run, material, methods))


def _content(run: "RunFolder", material: "Material", methods: "Sequence[Method]") -> dict[str, Any]:
    scores = Scores.read(run.scores)
    view = view_pair(run, material, methods, middle_pair(len(material.sequence) - 1))
    published = read_published("rotation") if is_published_rotation(run) else {}
    return {
        "title": scores.scene or material.folder.name,
        "description": _description(run),
        "facts": _facts(run, material, scores),
        "strata": MEANINGS,
        "bounds": WRONG_ABOVE,
        "published": _published_rows(published),
        "methods": _method_pages(scores, view, published),
        "region_columns": REGION_COLUMNS,
        "regions": _region_rows(scores),
        "pair": view.pair,
        "truth_panels": _truth_panels(view),
        "forces": _forces_panel(run, material, view.pair),
        "soundness": _soundness(run),
        "scene_toml": run.scene.read_text(encoding="utf-8") if run.scene.is_file() else "",
        "versions": package_versions(),
        "machine": machine(),
        "commands": _commands(run, material, methods),
        "program": package_version("softbed"),
    }


def _description(run: "RunFolder") -> str:
    if not run.scene.is_file():
        return "Pictures with their truth, scored."
    from synth import load_scene

    return load_scene(run.scene).description


def _facts(run: "RunFolder", material: "Material", scores: Scores) -> dict[str, str]:
    rows, columns = material.sequence.shape
    facts = {"pictures": f"{len(material.sequence)} of {columns} × {rows} px"}
    if material.sequence.metres_per_pixel:
        facts["scale"] = f"{1000 * material.sequence.metres_per_pixel:g} mm/px"
    if material.sequence.frame_rate:
        facts["frame rate"] = f"{material.sequence.frame_rate:g} per second"
    if scores.scene:
        facts["seed"] = str(scores.seed)
        facts["size"] = "quick: smaller and coarser" if scores.quick else "full"
    for step, name in (("simulate", "simulation"), ("render", "rendering")):
        if step in run.manifest.steps:
            facts[name] = f"{run.manifest.steps[step].seconds:.0f} s"
    return facts


def _published_rows(published: Mapping[str, Published]) -> dict[str, str]:
    if not published:
        return {}
    return {name: f"{published[name].value:.2f}" for name in ("median", "p95")} | {
        "where": published["p95"].where
    }


def _method_pages(scores: Scores, view: PairView, published: Mapping[str, Published]) -> list[MethodPage]:
    top = _top_speed(view)
    reference = {
        label: published[name].value for name, label in (("median", "median"), ("p95", "95 %")) if published
    }
    return [
        MethodPage(
            name=name,
            rows=[
                (stratum, cells(summary)) for stratum, summary in method.strata.items() if summary.pixel_count
            ],
            seconds=number(method.seconds_per_pair, ".2f"),
            sentence=_sentence(scores, name),
            panels=_method_panels(view, name, top, reference),
        )
        for name, method in scores.methods.items()
    ]


def _region_rows(scores: Scores) -> dict[str, list[str]]:
    return {
        name: region_cells(method.regions)
        for name, method in scores.methods.items()
        if method.regions is not None
    }


def _sentence(scores: Scores, name: str) -> str:
    """Put the result in words."""
    strata = scores.methods[name].strata
    everything, complicated = strata["all"], strata["complex"]
    if everything.median is None or everything.p95 is None:
        return "measured nothing"
    text = f"half of all soil is within {everything.median:.3f} px of the truth, "
    text += f"95 % within {everything.p95:.2f} px"
    if complicated.median is not None and complicated.p95 is not None:
        text += f"; in complex regions {complicated.median:.3f} px and {complicated.p95:.2f} px"
    averaging = scores.methods[name].averaging
    if averaging is not None and averaging.sentence:
        text += f"; {averaging.sentence}"
    return text


def _top_speed(view: PairView) -> float:
    speed = view.truth.speed[np.isfinite(view.truth.speed)]
    return max(float(np.percentile(speed, _TOP_PERCENTILE)), 1.0) if speed.size else 1.0


def _truth_panels(view: PairView) -> list[Panel]:
    return [
        Panel.of("What the camera saw", "The first picture of the pair.", draw_picture(view.picture)),
        Panel.of(
            "True speed",
            "Motion of the soil from this picture to the next, with the camera's motion taken out.",
            draw_speed(view.truth, view.picture, top=_top_speed(view)),
        ),
        Panel.of(
            "True direction",
            "Where the soil goes, as the picture shows it; soil slower than 0.3 px/frame is left out.",
            draw_direction(view.truth, view.picture),
        ),
        Panel.of(
            "Strata",
            "Which pixels are told apart; complex is drawn over moving, soil that is neither is quiet.",
            draw_strata(view.strata, view.picture),
        ),
    ]


def _method_panels(view: PairView, name: str, top: float, published: Mapping[str, float]) -> list[Panel]:
    measured = view.measured[name]
    missed = " Soil that was not measured is magenta." if measured.missed.any() else ""
    where = (
        "at every node of the grid, which fills its cell" if measured.gridded else "of every true soil pixel"
    )
    return [
        Panel.of(
            "Measured speed",
            "As the analysis says: its own soil mask, colours as for the truth. The camera moved by "
            f"{measured.camera_u:.2f} px by the analysis, by {view.camera_u:.2f} px in truth.",
            draw_speed(measured.motion, view.picture, top=top),
        ),
        Panel.of(
            "Measured direction",
            "As for the truth; compare the two.",
            draw_direction(measured.motion, view.picture),
        ),
        Panel.of(
            "Error",
            f"Distance between the measured and the true displacement {where}.{missed}",
            draw_error(measured, view.picture),
        ),
        Panel.of(
            "Distribution of the error",
            "Of this pair, in each stratum; the lines are the median and 95 % of all its soil.",
            draw_histogram(measured, view.strata, published=published),
        ),
    ]


def _forces_panel(run: "RunFolder", material: "Material", pair: int) -> Panel | None:
    if not run.forces.is_file():
        return None
    forces = _read_forces(run.forces)
    if len(forces["time"]) < 2:
        return None
    rate = material.sequence.frame_rate
    marked = pair / rate if rate else None
    caption = "Before time 0 is the run-in, without pictures. The dotted line marks the pair shown above."
    return Panel.of("Over time", caption, draw_forces(forces, marked=marked))


def _soundness(run: "RunFolder") -> "list[Judgement]":
    """What the simulation reports of itself; nothing where there were no grains to simulate."""
    from synth.dem.soundness import judge

    step = run.manifest.steps.get("simulate")
    return judge(step.facts.get("soundness", {})) if step else []


def _read_forces(path: Path) -> dict[str, np.ndarray]:
    """Columns of forces.csv by name, without the units of its header."""
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    values = np.array(rows, float).reshape(len(rows), len(header))
    return {column.split(" [")[0]: values[:, k] for k, column in enumerate(header)}


def _commands(run: "RunFolder", material: "Material", methods: "Sequence[Method]") -> list[str]:
    """List what a person types to get this page again."""
    asked = " ".join(f"--method {method.name}" for method in methods)
    if not run.scene.is_file():
        return [f"softbed score {material.folder.name} {asked}"]
    return [f"softbed run {_scene_argument(run)} OUT {asked}"]


def _scene_argument(run: "RunFolder") -> str:
    """Name the shipped scene with its options, or the resolved scene's file where it is none of them."""
    from synth import SceneError, load_scene, scene_names

    manifest = run.manifest
    if manifest.scene in scene_names():
        try:
            same = (
                load_scene(manifest.scene, quick=manifest.quick, seed=manifest.seed).hash
                == manifest.scene_hash
            )
        except SceneError:
            same = False
        if same:
            quick = " --quick" if manifest.quick else ""
            return f"{manifest.scene}{quick} --seed {manifest.seed}"
    return "scene.toml"
