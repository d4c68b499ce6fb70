"""What a wheel does to soil of coarser and finer grains, and whether the default is fine enough."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from synth.implements import RigidWheel
from synth.scene import SoilBinScene
from validation.studies.flow_field import Window, mean_flow
from validation.studies.study import (
    Case,
    Findings,
    Row,
    Run,
    Study,
    changed,
    column,
    error_bars,
    plain_axes,
    steady_means,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from synth.recording import Recording

DIAMETERS = (3.0e-3, 2.0e-3, 1.5e-3, 1.0e-3)
"""m."""
QUICK_DIAMETERS = (5.0e-3, 4.0e-3, 3.0e-3)
_QUICK_FRAMES = 17
_STATIONS = (-0.4, -0.2, 0.0, 0.2, 0.4)
"""Where the band's width is measured: distance ahead of the axle / wheel radius."""
_KERNEL = 0.5
"""Standard deviation of the coarse-graining / grain diameter; on a line it is 1.3 diameters wide itself."""
_SPACING = 0.25
"""Of the raster / grain diameter."""
_ABREAST = 0.1
"""Shear is averaged over so much to both sides of a station / wheel radius."""
_FLOOR = 0.1
"""Shear at a rate below this share of its peak is left out: it is scatter."""
_CENTRAL = 0.8


class GrainSize(Study):
    """The same wheel in beds of other grains."""

    scene = "rolling_wheel"
    columns: ClassVar[Mapping[str, str]] = {
        "grain_diameter": "mm",
        "grain_count": "1",
        "sinkage": "mm",
        "sinkage_deviation": "mm",
        "drawbar_pull": "N",
        "drawbar_pull_deviation": "N",
        "torque": "N m",
        "torque_deviation": "N m",
        "band_width": "mm",
        "band_width_deviation": "mm",
        "band_width_in_diameters": "1",
    }

    def cases(self, scene: SoilBinScene, *, quick: bool) -> list[Case]:
        """One for each diameter."""
        if not isinstance(scene.implement, RigidWheel):
            raise ValueError(f"{scene.name}: implement.kind = {scene.implement.kind!r}: a wheel is needed")
        diameters = QUICK_DIAMETERS if quick else DIAMETERS
        timing = {"frame_count": max(_QUICK_FRAMES, scene.timing.frame_count)}
        return [
            Case(f"{1000 * one:g}-mm", changed(scene, bed={"grain_diameter": one}, timing=timing))
            for one in diameters
        ]

    def find(self, runs: Sequence[Run]) -> Findings:
        """Means over time, and the width of the shear band over the stations."""
        rows = [_row(run.case.scene, run.recording()) for run in runs]
        return Findings(rows, _conclusion(rows))

    def draw(self, findings: Findings) -> "Figure":
        """Every quantity against grain diameter."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(8.4, 6.0), layout="constrained")
        grid = plain_axes(figure, 2, 2).ravel()
        rows = findings.rows
        diameter = column(rows, "grain_diameter")
        panels = (
            ("sinkage", "sinkage [mm]", "#b07d2b"),
            ("drawbar_pull", "drawbar pull [N]", "#e45756"),
            ("torque", "torque [N m]", "#4c78a8"),
            ("band_width", "shear-band width [mm]", "#54a24b"),
        )
        for axes, (name, label, colour) in zip(grid, panels, strict=True):
            error_bars(axes, diameter, column(rows, name), column(rows, f"{name}_deviation"), colour=colour)
            axes.set_ylabel(label)
            axes.set_xlabel("grain diameter [mm]")
            axes.set_xlim(0, 1.1 * diameter.max())
        top = 1.1 * np.nanmax(column(rows, "band_width") + column(rows, "band_width_deviation"))
        grid[3].set_ylim(0, top)
        for count in (10, 20, 30):
            at = min(0.95 * top / count, diameter.max())
            grid[3].axline((0, 0), slope=count, color="0.6", linewidth=0.8, linestyle=":")
            grid[3].annotate(f"{count} d", (at, count * at), color="0.4", fontsize=8, ha="right")
        figure.supxlabel("bars: standard deviation over time; of the width, over five stations", fontsize=8)
        return figure


STUDY = GrainSize()


def _row(scene: SoilBinScene, recording: "Recording") -> Row:
    means = steady_means(recording)
    diameter = scene.bed.grain_diameter
    widths = 1000 * band_widths(scene, recording)
    widths = widths[np.isfinite(widths)]
    width, scatter = (widths.mean(), widths.std()) if widths.size else (np.nan, np.nan)
    return {
        "grain_diameter": 1000 * diameter,
        "grain_count": float(recording.data.sizes["particle"]),
        "sinkage": 1000 * means["sinkage"][0],
        "sinkage_deviation": 1000 * means["sinkage"][1],
        "drawbar_pull": means["force_x"][0],
        "drawbar_pull_deviation": means["force_x"][1],
        "torque": means["torque"][0],
        "torque_deviation": means["torque"][1],
        "band_width": float(width),
        "band_width_deviation": float(scatter),
        "band_width_in_diameters": float(width / (1000 * diameter)),
    }


def band_widths(scene: SoilBinScene, recording: "Recording") -> np.ndarray:
    """Width of the shear band below a wheel at each station, m; NaN where no soil is below the rim."""
    assert isinstance(scene.implement, RigidWheel)
    radius, diameter = scene.implement.radius, scene.bed.grain_diameter
    surface = float(recording.data.attrs["surface_height"])
    axle = float(recording.data["implement_z"].values.mean()) - surface
    reach = 0.6 * radius  # past the outermost stations and what is abreast of them
    field = mean_flow(
        recording,
        Window(-reach, reach, -surface, 0.0),
        spacing=_SPACING * diameter,
        kernel=_KERNEL * diameter,
    )
    shear = field.shear
    shear[:, field.z[:, None] > axle - np.sqrt(radius**2 - field.x**2)] = np.nan
    widths = []
    for station in _STATIONS:
        abreast = np.abs(field.x - station * radius) <= max(_ABREAST * radius, diameter)
        known = np.isfinite(shear[:, :, abreast]).all(axis=0).any(axis=1)
        # Components first, so that scatter cancels out; from the floor up to the rim.
        rate = np.hypot(*np.nanmean(shear[:, known][:, :, abreast], axis=2))
        widths.append(band_width(rate, _SPACING * diameter))
    return np.array(widths)


def band_width(rate: np.ndarray, spacing: float) -> float:
    """Width that holds the central 80 % of the shear, m.

    Along a line that crosses the band, shear at less than a tenth of the greatest rate left out: the distance
    between where a tenth and where nine tenths of the rest is reached. A band of even shear gives 0.8 of its
    width, a Gaussian one 2.4 standard deviations.

    Parameters
    ----------
    rate : ndarray, shape (n,)
        Shear rate along a line.
    spacing : float
        m.
    """
    if rate.size < 3 or not rate.max() > 0:
        return float("nan")
    counted = np.where(rate < _FLOOR * rate.max(), 0.0, rate)
    total = np.concatenate([[0.0], np.cumsum(counted)])
    shares = np.array([1 - _CENTRAL, 1 + _CENTRAL]) / 2
    # The first place that a share is reached at: sums stand still where nothing is counted.
    place = np.searchsorted(total, shares * total[-1])
    into = (shares * total[-1] - total[place - 1]) / counted[place - 1]
    return float(np.diff(place - 1 + into)[0]) * spacing


def _conclusion(rows: Sequence[Row]) -> str:
    ordered = sorted(rows, key=lambda row: float(row["grain_diameter"]))
    finest, coarsest = ordered[0], ordered[-1]
    changes = []
    for name, unit in (("sinkage", "mm"), ("drawbar_pull", "N"), ("torque", "N m")):
        fine, coarse = float(finest[name]), float(coarsest[name])
        changes.append(f"{name.replace('_', ' ')} from {coarse:.3g} to {fine:.3g} {unit}")
    diameter, width = column(ordered, "grain_diameter"), column(ordered, "band_width")
    slope, offset = np.polyfit(diameter, width, 1)
    return (
        f"From {coarsest['grain_diameter']:g} to {finest['grain_diameter']:g} mm grains, "
        f"{', '.join(changes)}; the shear band is {offset:.1f} mm + {slope:.1f} diameters wide "
        f"({width.min():.1f} to {width.max():.1f} mm)."
    )
