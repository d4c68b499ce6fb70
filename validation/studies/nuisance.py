"""How much each disturbance of a real rig adds to the error of each estimator.

One recording each of a plate's rotation and of a rolling wheel is photographed again and again, with one
severity of the scene's table [nuisance] raised at a time.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from soft.flow import installed
from synth.scene import PlateScene, Scene, SoilBinScene, load_scene, parse_scene
from validation.scoring.metrics import ErrorSummary
from validation.studies.picture_errors import WRONG, Measurement, PictureStudy, pair_count, picture_errors
from validation.studies.study import Case, Findings, Row, Run, plain_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from synth.recording import Recording

SEVERITIES: dict[str, tuple[float, ...]] = {
    "exposure": (0.25, 0.5, 1.0),
    "distortion": (0.02, 0.05, 0.1),
    "jitter": (0.02, 0.05, 0.1),
    "vibration": (0.5, 1.0, 2.0),
    "flicker": (0.02, 0.05, 0.1),
    "exchange": (0.05, 0.1, 0.2),
    "scratches": (0.1, 0.2, 0.4),
    "smudges": (0.25, 0.5, 1.0),
    "dirt": (0.25, 0.5, 1.0),
    "reflections": (0.1, 0.2, 0.4),
}
"""By key of [nuisance]; the greatest of each is about the worst that a rig still in use would show."""
CLEAN = "none"
_COLOURS = ("#4c78a8", "#e45756", "#54a24b", "#b07d2b", "#7b5ea7", "0.3")
_PANELS = (
    ("plate_rotation", "all", "p95", "plate:\n95 % error [px]"),
    ("rolling_wheel", "all", "p95", "wheel, all soil:\n95 % error [px]"),
    ("rolling_wheel", "complex", "wrong", "wheel, complex:\nabove 1 px [%]"),
)
"""Scene (by its kind), stratum and quantity of the figure's rows."""


class NuisanceSweep(PictureStudy):
    """Pictures of two recordings, each nuisance by itself at three severities."""

    scene = "rolling_wheel"
    columns: ClassVar[Mapping[str, str]] = {
        "scene": "",
        "nuisance": "",
        "severity": "1",
        "method": "",
        "stratum": "",
        "pixel_count": "1",
        "coverage": "1",
        "median": "px",
        "p95": "px",
        "wrong": "%",
    }

    def cases(self, scene: SoilBinScene, *, quick: bool) -> list[Case]:
        """The wheel alone: a plate's rotation needs no simulation."""
        return [Case("rolling_wheel", scene)]

    @property
    def inputs(self) -> Mapping[str, Any]:
        """Findings depend on the estimators there are, and on the severities."""
        return {"methods": installed(), "severities": SEVERITIES}

    def measurements(self, runs: Sequence[Run]) -> list[Measurement]:
        """Errors of every estimator in the clean pictures and in the disturbed ones."""
        from synth import simulate

        wheel = runs[0].case.scene
        plate = load_scene("plate_rotation", quick=wheel.quick, seed=wheel.seed)
        assert isinstance(plate, PlateScene)
        on_plate, under_wheel = cache(partial(simulate, plate)), cache(runs[0].recording)
        return [
            *_measurements("plate_rotation", plate, on_plate, ("all",)),
            *_measurements("rolling_wheel", wheel, under_wheel, ("all", "complex")),
        ]

    def conclusion(self, rows: Sequence[Row]) -> str:
        """What raises the 95 % error over all the wheel's soil most, method by method."""
        return f"95 % error over all the wheel's soil: {'; '.join(_worst_of_each_method(rows))}."

    def draw(self, findings: Findings) -> "Figure":
        """One column a nuisance, errors on a logarithmic scale; dotted: the clean picture."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(13, 5.6), layout="constrained")
        grid = plain_axes(figure, len(_PANELS), len(SEVERITIES))
        methods = sorted({str(row["method"]) for row in findings.rows})
        for line, (scene, stratum, quantity, label) in enumerate(_PANELS):
            chosen = [r for r in findings.rows if (r["scene"], r["stratum"]) == (scene, stratum)]
            low, top = _span([float(row[quantity]) for row in chosen])
            for place, nuisance in enumerate(SEVERITIES):
                axes = grid[line, place]
                for method, colour in zip(methods, _COLOURS, strict=False):
                    own = [row for row in chosen if row["method"] == method]
                    _draw_lines(axes, own, nuisance, quantity, colour)
                axes.set_xlim(0)
                axes.set_yscale("log", nonpositive="clip")
                axes.set_ylim(low, top)
                axes.tick_params(labelsize=7)
                axes.set_title(nuisance if line == 0 else "", fontsize=9)
                if place:
                    axes.set_yticklabels([])
            grid[line, 0].set_ylabel(label, fontsize=8)
        for axes in grid[-1]:
            axes.set_xlabel("severity", fontsize=8)
        lines = grid[1, 0].get_legend_handles_labels()
        figure.legend(*lines, loc="outside lower center", ncols=len(methods), frameon=False)
        return figure


STUDY = NuisanceSweep()


def _measurements(
    name: str, clean: Scene, recording: "Callable[[], Recording]", strata: Sequence[str]
) -> list[Measurement]:
    return [
        Measurement(
            f"{name}-{nuisance}-{severity:g}",
            partial(_rows, name, clean, recording, nuisance, severity, strata),
        )
        for nuisance, severity in _levels(clean)
    ]


def _rows(
    name: str,
    clean: Scene,
    recording: "Callable[[], Recording]",
    nuisance: str,
    severity: float,
    strata: Sequence[str],
) -> list[Row]:
    scene = clean if nuisance == CLEAN else disturbed(clean, {nuisance: severity})
    count = pair_count(quick=scene.quick)
    errors = picture_errors(recording(), scene, installed(), pair_count=count)
    rows: list[Row] = []
    for method, summaries in errors.items():
        told: Row = {"scene": name, "nuisance": nuisance, "severity": severity, "method": method}
        rows += [{**told, "stratum": stratum, **error_columns(summaries[stratum])} for stratum in strata]
    return rows


def _levels(scene: Scene) -> list[tuple[str, float]]:
    """Nuisances and severities, the clean picture first; a camera that stands does not vibrate."""
    still = scene.camera.follows == "bin"
    levels = [(name, severity) for name, several in SEVERITIES.items() for severity in several]
    return [(CLEAN, 0.0), *(level for level in levels if not (still and level[0] == "vibration"))]


def disturbed(clean: Scene, severities: Mapping[str, float]) -> Scene:
    """The scene with some severities of its table [nuisance] changed."""
    told = clean.to_dict()
    told["nuisance"] = {**told["nuisance"], **severities}
    scene = parse_scene(told, source=f"{clean.name} with {dict(severities)}")
    assert isinstance(scene, Scene)
    return scene


def error_columns(errors: ErrorSummary) -> Row:
    """What the tables of errors in pictures have of a stratum; NaN where nothing was measured."""
    shares = {
        name: math.nan if value is None else value
        for name, value in (("coverage", errors.coverage), ("median", errors.median), ("p95", errors.p95))
    }
    wrong = errors.wrong_share[WRONG]
    return {
        "pixel_count": errors.pixel_count,
        **shares,
        "wrong": math.nan if wrong is None else 100 * wrong,
    }


def _span(values: Sequence[float]) -> tuple[float, float]:
    """Ends of a logarithmic axis for values of which some may be zero or unknown."""
    positive = [value for value in values if value > 0]
    return (min(positive) / 1.3, max(positive) * 1.3) if positive else (0.1, 1.0)


def _draw_lines(axes: "Axes", rows: Sequence[Row], nuisance: str, quantity: str, colour: str) -> None:
    """One method's error against severity, from that in the clean picture on."""
    points = [
        (float(row["severity"]), float(row[quantity])) for row in rows if row["nuisance"] in (CLEAN, nuisance)
    ]
    if not points:
        return
    severity, value = np.array(points).T
    axes.axhline(value[0], color=colour, linestyle=":", linewidth=0.8)
    if len(points) > 1:
        axes.plot(
            severity, value, marker="o", markersize=3, linewidth=1.2, color=colour, label=rows[0]["method"]
        )
    else:
        axes.text(0.5, 0.5, "camera stands", transform=axes.transAxes, fontsize=7, ha="center", color="0.4")


def _worst_of_each_method(rows: Sequence[Row]) -> list[str]:
    words = []
    for method in sorted({str(row["method"]) for row in rows}):
        own = [
            row
            for row in rows
            if (row["method"], row["scene"], row["stratum"]) == (method, "rolling_wheel", "all")
        ]
        clean = next(float(row["p95"]) for row in own if row["nuisance"] == CLEAN)
        worst = sorted(own, key=lambda row: -float(row["p95"]))
        names = list(dict.fromkeys(str(row["nuisance"]) for row in worst))[:3]
        first = worst[0]
        words.append(
            f"{method} {clean:.2f} px clean, {float(first['p95']):.2f} px with {first['nuisance']} "
            f"{first['severity']:g} (then {', '.join(names[1:])})"
        )
    return words
