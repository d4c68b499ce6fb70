"""Whether complex flow is the soil's or the simulation's: errors there against the size of the particles.

Micro-grains that follow the smooth field of the particles (`interpolated`) do not know how large these are;
those that ride rigidly on one particle (`carried`) make tiles, whose edges are discontinuities of their own.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from soft.flow import installed
from synth.scene import SoilBinScene
from validation.studies.nuisance import error_columns
from validation.studies.picture_errors import Measurement, PictureStudy, pair_count, picture_errors
from validation.studies.study import Case, Findings, Row, Run, changed, column, plain_axes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from synth.recording import Recording

TEXTURES = ("interpolated", "carried")
_FACTORS = (1.0, 1.4, 2.0)
"""Particle diameters / the scene's own."""
_COLOURS = ("#4c78a8", "#e45756", "#54a24b", "#b07d2b", "#7b5ea7", "0.3")


class TextureMotion(PictureStudy):
    """The same wheel in ever coarser particles, photographed with both textures."""

    scene = "rolling_wheel"
    columns: ClassVar[Mapping[str, str]] = {
        "grain_diameter": "mm",
        "diameter_in_picture": "px",
        "texture": "",
        "method": "",
        "complex_share": "%",
        "pixel_count": "1",
        "coverage": "1",
        "median": "px",
        "p95": "px",
        "wrong": "%",
        "wrong_of_all": "%",
    }

    def cases(self, scene: SoilBinScene, *, quick: bool) -> list[Case]:
        """Three sizes of particles; quick, they are coarser because the quick scene's are."""
        sizes = [factor * scene.bed.grain_diameter for factor in _FACTORS]
        return [Case(f"{1000 * size:.3g}-mm", changed(scene, bed={"grain_diameter": size})) for size in sizes]

    @property
    def inputs(self) -> Mapping[str, Any]:
        """Findings depend on the estimators there are."""
        return {"methods": installed()}

    def measurements(self, runs: Sequence[Run]) -> list[Measurement]:
        """Errors of every estimator in complex flow, of either texture."""
        found = []
        for run in runs:
            recording = cache(run.recording)
            for texture in TEXTURES:
                scene = changed(run.case.scene, texture={"motion": texture})
                found.append(Measurement(f"{run.case.label}-{texture}", partial(_rows, scene, recording)))
        return found

    def conclusion(self, rows: Sequence[Row]) -> str:
        """How the wrong share of complex flow changes from the finest to the coarsest particles."""
        return _conclusion(rows)

    def draw(self, findings: Findings) -> "Figure":
        """Share of complex pixels, their median error, and the share of them that is wrong."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(10.5, 3.8), layout="constrained")
        grid = plain_axes(figure, 1, 3).ravel()
        methods = sorted({str(row["method"]) for row in findings.rows})
        for texture, style in zip(TEXTURES, ("-", "--"), strict=True):
            for method, colour in zip(methods, _COLOURS, strict=False):
                own = [row for row in findings.rows if (row["texture"], row["method"]) == (texture, method)]
                size = column(own, "diameter_in_picture")
                look = {"linestyle": style, "marker": "o", "markersize": 4}
                if method == methods[0]:
                    grid[0].plot(size, column(own, "complex_share"), color="0.3", label=texture, **look)
                label = method if texture == TEXTURES[0] else None
                for axes, quantity in ((grid[1], "median"), (grid[2], "wrong")):
                    axes.plot(size, column(own, quantity), color=colour, label=label, **look)
        for axes, label in zip(
            grid,
            ("soil that is complex [%]", "median error in complex flow [px]", "complex flow, above 1 px [%]"),
            strict=True,
        ):
            axes.set_xlabel("particle diameter [px]")
            axes.set_ylabel(label)
            axes.set_xlim(0)
            axes.set_ylim(0)
        handles, labels = (
            [*textures, *of_methods]
            for textures, of_methods in zip(
                grid[0].get_legend_handles_labels(), grid[1].get_legend_handles_labels(), strict=True
            )
        )
        figure.legend(
            handles, labels, loc="outside lower center", ncols=len(labels), frameon=False, fontsize=8
        )
        return figure


STUDY = TextureMotion()


def _rows(scene: SoilBinScene, recording: "Callable[[], Recording]") -> list[Row]:
    diameter, count = scene.bed.grain_diameter, pair_count(quick=scene.quick)
    errors = picture_errors(recording(), scene, installed(), pair_count=count)
    return [
        {
            "grain_diameter": 1000 * diameter,
            "diameter_in_picture": diameter / scene.camera.metres_per_pixel,
            "texture": scene.texture.motion,
            "method": method,
            "complex_share": 100 * strata["complex"].pixel_count / max(strata["all"].pixel_count, 1),
            **error_columns(strata["complex"]),
            "wrong_of_all": error_columns(strata["all"])["wrong"],
        }
        for method, strata in errors.items()
    ]


def _conclusion(rows: Sequence[Row]) -> str:
    finest, coarsest = (f(float(row["grain_diameter"]) for row in rows) for f in (min, max))
    words = []
    for texture in TEXTURES:
        ends = [
            np.mean(
                [float(r["wrong"]) for r in rows if (r["texture"], r["grain_diameter"]) == (texture, size)]
            )
            for size in (finest, coarsest)
        ]
        words.append(f"{texture} {ends[0]:.1f} % to {ends[1]:.1f} %")
    return (
        f"Complex flow that is wrong by more than 1 px, mean of the methods, particles of {finest:.1f} to "
        f"{coarsest:.1f} mm: {', '.join(words)}."
    )
