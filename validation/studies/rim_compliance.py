"""How much less soil a wheel with an elastic rim moves than a rigid one, at the same slip and load.

Skonieczny et al., *J. Field Robotics* 31(5), 2014, figure 13: an order of magnitude, for a wheel whose
stiffness is not stated.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from synth.drive import Rolling
from synth.implements import CompliantWheel
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

    from synth.recording import Recording

DEFLECTIONS = (0.1, 0.2, 0.3, 0.4)
"""On a rigid floor / radius."""
RIGID = "rigid"
_ABREAST, _BELOW = 1.0, 0.5
"""Soil below the wheel: so far to both sides of the axle, and so deep below the levelled surface / radius."""
_MOVING = 0.1
"""Soil that moves: faster than this share of the rim."""


class RimCompliance(Study):
    """The same wheel with a rigid rim, and with ever softer ones."""

    scene = "compliant_wheel"
    columns: ClassVar[Mapping[str, str]] = {
        "wheel": "",
        "nominal_deflection": "mm",
        "deflection": "mm",
        "sinkage": "mm",
        "contact_length": "mm",
        "pressure": "kPa",
        "rolling_radius": "mm",
        "slip_at_rolling_radius": "1",
        "drawbar_pull": "N",
        "torque": "N m",
        "median_speed": "mm/s",
        "p95_speed": "mm/s",
        "moving_area": "mm2",
        "median_ratio": "1",
        "p95_ratio": "1",
        "area_ratio": "1",
    }

    def cases(self, scene: SoilBinScene, *, quick: bool) -> list[Case]:
        """The rigid wheel first; quick, beside it the scene's own rim and one that gives way half as far."""
        wheel = scene.implement
        if not isinstance(wheel, CompliantWheel) or not isinstance(scene.drive, Rolling):
            raise ValueError(
                f"{scene.name}: implement.kind = {wheel.kind!r}: a rolling compliant wheel is needed"
            )
        keys = ("radius", "width", "normal_load", "moving_mass")
        rigid = {"kind": "rigid_wheel", **{key: getattr(wheel, key) for key in keys}}
        # A whole table is given: none of the elastic rim's keys mean anything for a rigid one.
        told = {**scene.to_dict(), "implement": rigid}
        first = Case(RIGID, _parsed(told, scene.name))
        own = wheel.deflection / wheel.radius
        return [first, *(_softer(scene, share) for share in ((own / 2, own) if quick else DEFLECTIONS))]

    def find(self, runs: Sequence[Run]) -> Findings:
        """Speeds of the soil below the wheels, and their ratios to those of the rigid one."""
        rows = [_row(run.case.scene, run.recording()) for run in runs]
        for row in rows:
            for name, of in (("median", "median_speed"), ("p95", "p95_speed"), ("area", "moving_area")):
                base = float(rows[0][of])
                row[f"{name}_ratio"] = float(row[of]) / base if base > 0 else np.nan
        return Findings(rows, _conclusion(rows))

    def draw(self, findings: Findings) -> "Figure":
        """Ratios of soil motion, and what the soil carries, against deflection."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(8.4, 3.4), layout="constrained")
        ratios, pressures = plain_axes(figure, 1, 2).ravel()
        rows = findings.rows
        deflection = column(rows, "deflection")
        for name, label, colour in (
            ("median_ratio", "median speed", "#4c78a8"),
            ("p95_ratio", "95 % speed", "#e45756"),
            ("area_ratio", "moving area", "#54a24b"),
        ):
            ratios.plot(deflection, column(rows, name), marker="o", color=colour, label=label)
        ratios.axhline(0.1, color="0.5", linestyle=":", linewidth=1)
        ratios.annotate(
            "an order of magnitude", (1, 0.1), (0, -3), xycoords=("axes fraction", "data"),
            textcoords="offset points", fontsize=8, ha="right", va="top",
        )  # fmt: skip
        ratios.set_ylim(0, 1.1 * np.nanmax([column(rows, f"{n}_ratio") for n in ("median", "p95", "area")]))
        ratios.set_ylabel("compliant / rigid wheel [1]")
        ratios.legend(frameon=False, fontsize=8)
        for name, label, colour in (
            ("pressure", "pressure [kPa]", "#b07d2b"),
            ("sinkage", "sinkage [mm]", "0.3"),
        ):
            pressures.plot(deflection, column(rows, name), marker="o", color=colour, label=label)
        pressures.set_ylim(0)
        pressures.legend(frameon=False, fontsize=8)
        for axes in (ratios, pressures):
            axes.set_xlabel("deflection in the soil [mm]")
        return figure


STUDY = RimCompliance()


def _softer(scene: SoilBinScene, share: float) -> Case:
    radius = scene.implement.radius  # type: ignore[union-attr]
    soft = changed(scene, implement={"deflection": share * radius})
    return Case(f"{100 * share:.0f}-percent", soft)


def _parsed(tables: dict, name: str) -> SoilBinScene:
    from synth.scene import parse_scene

    scene = parse_scene(tables, source=f"{name}, with a rigid wheel")
    assert isinstance(scene, SoilBinScene)
    return scene


def _row(scene: SoilBinScene, recording: "Recording") -> Row:
    wheel, drive = scene.implement, scene.drive
    assert isinstance(drive, Rolling)
    means, data = steady_means(recording), recording.data
    since = data["sample_time"].values > 0
    rim = {
        name: float(data[name].values[since].mean()) if name in data else default
        for name, default in (("deflection", 0.0), ("rolling_radius", wheel.radius))  # type: ignore[union-attr]
    }
    length = contact_length(scene, recording)
    spin = drive.rim_speed / wheel.radius  # type: ignore[union-attr]
    speed, area = speeds_below(scene, recording)
    moving = speed > _MOVING * drive.rim_speed
    return {
        "wheel": "compliant" if isinstance(wheel, CompliantWheel) else RIGID,
        "nominal_deflection": 1000 * getattr(wheel, "deflection", 0.0),
        "deflection": 1000 * rim["deflection"],
        "sinkage": 1000 * means["sinkage"][0],
        "contact_length": 1000 * length,
        "pressure": means["force_z"][0] / wheel.width / length / 1000 if length > 0 else np.nan,
        "rolling_radius": 1000 * rim["rolling_radius"],
        "slip_at_rolling_radius": 1 - drive.carriage_speed / (spin * rim["rolling_radius"]),
        "drawbar_pull": means["force_x"][0],
        "torque": means["torque"][0],
        "median_speed": 1000 * _weighted_quantile(speed, area, 0.5),
        "p95_speed": 1000 * _weighted_quantile(speed, area, 0.95),
        "moving_area": 1e6 * float(area[moving].sum()) / (recording.frame_count - 1),
        "median_ratio": np.nan,
        "p95_ratio": np.nan,
        "area_ratio": np.nan,
    }


def speeds_below(scene: SoilBinScene, recording: "Recording") -> tuple[np.ndarray, np.ndarray]:
    """Speed (m/s) and area with its voids (m2) of all grains below the wheel, over all frame pairs.

    Below: up to a radius to both sides of the axle, and from the levelled surface down to half a radius; for
    every wheel the same rectangle.
    """
    data, radius = recording.data, scene.implement.radius  # type: ignore[union-attr]
    surface, time = float(data.attrs["surface_height"]), data["time"].values
    x, z, axle = (data[name].values for name in ("position_x", "position_z", "implement_x"))
    area = np.pi * data["radius"].values ** 2 / float(data.attrs["solid_fraction"])
    speed, weight = [], []
    for frame, following in zip(range(len(time) - 1), range(1, len(time)), strict=True):
        chosen = np.abs(x[frame] - axle[frame]) < _ABREAST * radius
        chosen &= (z[frame] < surface) & (z[frame] > surface - _BELOW * radius)
        moved = np.hypot(x[following] - x[frame], z[following] - z[frame])[chosen]
        speed.append(moved / (time[following] - time[frame]))
        weight.append(area[chosen])
    return np.concatenate(speed), np.concatenate(weight)


def contact_length(scene: SoilBinScene, recording: "Recording") -> float:
    """Mean over frames of the extent of the contacts that carry the middle 95 % of the upward force, m."""
    from synth.dem.rim import contact_extent

    data, lengths = recording.data, []
    for frame in range(recording.frame_count):
        position = np.stack([data["position_x"].values[frame], data["position_z"].values[frame]], axis=1)
        axle = float(data["implement_x"].values[frame]), float(data["implement_z"].values[frame])
        section = recording.section(scene.implement.shape, frame)
        lengths.append(np.ptp(contact_extent(section, position - axle, data["radius"].values)))
    return float(np.mean(lengths))


def _weighted_quantile(values: np.ndarray, weights: np.ndarray, share: float) -> float:
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(total, share * total[-1])])


def _conclusion(rows: Sequence[Row]) -> str:
    softest = max(rows, key=lambda row: float(row["deflection"]))
    median, p95, area = (float(softest[f"{name}_ratio"]) for name in ("median", "p95", "area"))
    return (
        f"At the same slip and load, below a rim that gives way by {softest['deflection']:.0f} mm in soil, "
        f"soil moves at {median:.2f} (median) and {p95:.2f} (95 %) of the speed below the rigid wheel, over "
        f"{area:.2f} of the area; mean pressure {rows[0]['pressure']:.1f} kPa under the rigid wheel, "
        f"{softest['pressure']:.1f} kPa under this one."
    )
