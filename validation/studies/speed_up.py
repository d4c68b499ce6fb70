"""What driving the implement faster than in the laboratory changes, and how fast is still quasi-static."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from synth.scene import SoilBinScene
from validation.studies.study import (
    Case,
    Findings,
    Row,
    Run,
    Study,
    changed,
    column,
    plain_axes,
    steady_means,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from synth.dem.soundness import MovingSoil
    from synth.recording import Recording

SPEED_UPS = (20.0, 10.0, 5.0, 2.5)
_QUICK_GRAINS = 4.0e-3
"""m."""
_FRAMES = 24
"""Frames looked at, evenly over the run."""
_LIMIT = 3e-3
"""On the 95 % inertial number of the soil that carries the load."""
_BINS = 12
"""Of pressure, each with as many grains."""
_NUMBERS = {
    "p95_carrying": "95 %, each grain by the load it carries",
    "median_carrying": "median, by load",
    "p95": "95 %, each grain alike",
    "median": "median, each grain alike",
}


class SpeedUp(Study):
    """The same run, slower and slower.

    Shear rate and with it the inertial number go down as the speed does. `slope` is the power of the speed
    that a number follows from one case to the next; 1 says that it can be scaled to any speed.
    """

    scene = "rolling_wheel"
    columns: ClassVar[Mapping[str, str]] = {
        "speed_up": "1",
        **dict.fromkeys(_NUMBERS, "1"),
        "slope": "1",
        "largest_speed_up": "1",
        "sinkage": "mm",
        "drawbar_pull": "N",
        "torque": "N m",
    }

    def cases(self, scene: SoilBinScene, *, quick: bool) -> list[Case]:
        """One for each speed, the fastest first."""
        bed = {"grain_diameter": max(_QUICK_GRAINS, scene.bed.grain_diameter)} if quick else {}
        return [Case(f"{one:g}-fold", changed(scene, bed=bed, timing={"speed_up": one})) for one in SPEED_UPS]

    def find(self, runs: Sequence[Run]) -> Findings:
        """Inertial numbers, and what of them the pressure explains."""
        rows: list[Row] = []
        curves = {}
        for run in runs:
            recording, speed_up = run.recording(), run.case.scene.timing.speed_up
            soil = soil_that_moves(run.case.scene, recording)
            rows.append({"speed_up": speed_up, **_numbers(soil), **_means(recording)})
            curves[f"{speed_up:g}"] = number_by_pressure(soil)
        for row, before in zip(rows, [None, *rows], strict=False):
            row["largest_speed_up"] = float(row["speed_up"]) * _LIMIT / float(row["p95_carrying"])
            row["slope"] = _slope(row, before)
        return Findings(rows, _conclusion(rows), curves)

    def draw(self, findings: Findings) -> "Figure":
        """Numbers against speed; and against pressure, scaled to the laboratory's speed."""
        from cmcrameri import cm
        from matplotlib.figure import Figure

        figure = Figure(figsize=(9.6, 4.2), layout="constrained")
        left, right = plain_axes(figure, 1, 2)[0]
        speed = column(findings.rows, "speed_up")
        styles = (("#4c78a8", "-"), ("#4c78a8", ":"), ("#e45756", "-"), ("#e45756", ":"))
        for (name, label), (colour, style) in zip(_NUMBERS.items(), styles, strict=True):
            values = column(findings.rows, name)
            left.loglog(speed, values, style, marker="o", markersize=4, color=colour, label=label)
        left.axhline(_LIMIT, color="black", linewidth=0.8)
        left.annotate("limit", (0.01, _LIMIT), xycoords=("axes fraction", "data"), fontsize=8, va="bottom")
        left.set_xlim(1, 1.3 * speed.max())
        left.set_xticks([1, 2, 5, 10, 20], ["1", "2", "5", "10", "20"])
        left.set_xlabel("simulated / laboratory speed")
        left.set_ylabel("inertial number")
        left.legend(frameon=False, fontsize=8)
        colours = cm.batlow(np.linspace(0, 0.85, len(findings.curves)))
        for (name, (pressure, number)), colour in zip(findings.curves.items(), colours, strict=True):
            label = f"{name} times as fast"
            right.loglog(pressure, number / float(name), "o-", markersize=4, color=colour, label=label)
        right.axhline(_LIMIT, color="black", linewidth=0.8)
        right.set_xlabel("pressure [Pa]")
        right.set_ylabel("95 % inertial number / speed-up")
        right.legend(frameon=False, fontsize=8)
        figure.supxlabel("right: soil in twelve classes of pressure, as many grains in each", fontsize=8)
        return figure


STUDY = SpeedUp()


def soil_that_moves(scene: SoilBinScene, recording: "Recording") -> "MovingSoil":
    """The soil that moves, over frames of a recording of discs."""
    from synth.dem.bed import contact_law
    from synth.dem.grains import Grains
    from synth.dem.log import Frame
    from synth.dem.soundness import MovingSoil, moving_soil
    from synth.dem.tool import Tool

    data, fast, law = recording.data, scene.timing.speed_up, contact_law(scene)
    density = scene.soil.bulk_density
    radius = data["radius"].values.astype(float)
    parts = []
    for frame in np.unique(np.linspace(0, recording.frame_count - 1, _FRAMES).astype(int)):
        one = data.isel(frame=frame)
        names = (("position_x", "position_z"), ("velocity_x", "velocity_z"))
        position, velocity = (np.stack([one[name].values for name in pair]).astype(float) for pair in names)
        still = np.zeros(radius.size)
        grains = Grains(
            position, fast * velocity, still, still, radius, density / data.attrs["solid_fraction"]
        )
        speed_x, speed_z, spin, _ = scene.program.at(float(one["time"]))
        x, z, angle = (float(one[f"implement_{name}"]) for name in ("x", "z", "angle"))
        tool = Tool(scene.implement.shape, x, z, angle, fast * speed_x, fast * speed_z, fast * spin)
        parts.append(moving_soil(Frame(tool, grains), law, density))
    return MovingSoil.together(parts)


def number_by_pressure(soil: "MovingSoil") -> np.ndarray:
    """Median pressure (Pa) and 95 % inertial number of soil in classes of pressure, shape (2, classes)."""
    classes = np.array_split(np.argsort(soil.pressure), _BINS)
    pressure = [np.median(soil.pressure[one]) for one in classes if one.size]
    number = [np.quantile(soil.inertial_number[one], 0.95) for one in classes if one.size]
    return np.array([pressure, number])


def _numbers(soil: "MovingSoil") -> Row:
    from synth.dem.soundness import weighted_quantile

    number = soil.inertial_number
    return {
        "p95_carrying": weighted_quantile(number, soil.load, 0.95),
        "median_carrying": weighted_quantile(number, soil.load, 0.5),
        "p95": float(np.quantile(number, 0.95)),
        "median": float(np.median(number)),
    }


def _means(recording: "Recording") -> Row:
    means = steady_means(recording)
    return {
        "sinkage": 1000 * means["sinkage"][0],
        "drawbar_pull": means["force_x"][0],
        "torque": means["torque"][0],
    }


def _slope(row: Row, before: Row | None) -> float:
    """Power of the speed that the 95 % by load follows between two cases."""
    if before is None:
        return float("nan")
    number, speed = (float(row[name]) / float(before[name]) for name in ("p95_carrying", "speed_up"))
    return float(np.log(number) / np.log(speed))


def _conclusion(rows: Sequence[Row]) -> str:
    slowest = min(rows, key=lambda row: float(row["speed_up"]))
    alike = float(slowest["p95"]) / float(slowest["speed_up"])
    return (
        f"At {slowest['speed_up']:g} times the laboratory's speed, 95 % of the load is carried at an "
        f"inertial number below {slowest['p95_carrying']:.2g}; up to {slowest['largest_speed_up']:.2g} times "
        f"keep {_LIMIT:g}. Counted alike, 95 % of moving soil reach {alike:.2g} at the laboratory speed."
    )
