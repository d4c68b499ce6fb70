"""A calibration at a glance: what was searched, what was not fitted to, how grains settle, the plate."""

from typing import TYPE_CHECKING

import numpy as np

from synth.soil import Published
from validation.calibration.calibrate import Calibration

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MODEL, _PUBLISHED, _CHOSEN = "#4c78a8", "#54a24b", "#e45756"


def calibration_figure(calibration: Calibration, published: Published | None) -> "Figure":
    """Draw a calibration; `published` is drawn where there is one."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 7.0), layout="constrained")
    axes = figure.subplots(2, 2)
    _draw_search(axes[0, 0], calibration)
    _draw_density(axes[0, 1], calibration, published)
    _draw_packing(axes[1, 0], calibration)
    _draw_plate(axes[1, 1], calibration)
    name, contact = calibration.soil.name, calibration.soil.contact
    figure.suptitle(f"{name}: friction {contact.friction:g}, rolling friction {contact.rolling_friction:g}")
    return figure


def _draw_search(axes: "Axes", calibration: Calibration) -> None:
    points, target = calibration.tried, calibration.target
    axes.errorbar(
        [point.rolling_friction for point in points],
        [point.angle for point in points],
        [point.angle_error for point in points],
        fmt="o-",
        color=_MODEL,
        capsize=3,
        label="biaxial test, standard error",
    )
    axes.axhline(target.friction_angle, color=_PUBLISHED, label="published")
    axes.plot(
        calibration.found.rolling_friction,
        calibration.found.angle,
        "s",
        color=_CHOSEN,
        label="chosen",
        zorder=3,
    )
    axes.set(xlabel="rolling friction", ylabel="peak friction angle [deg]")
    axes.set_title(f"relative density {target.relative_density:.2f}")
    axes.legend()


def _draw_density(axes: "Axes", calibration: Calibration, published: Published | None) -> None:
    points = [calibration.loosest, calibration.found, calibration.densest]
    axes.errorbar(
        [point.relative_density for point in points],
        [point.angle for point in points],
        [point.angle_error for point in points],
        fmt="o",
        color=_MODEL,
        capsize=3,
        label="biaxial test, standard error",
    )
    if published is not None:
        ends = np.array([0.0, 1.0])
        angles = [published.friction_angle(end) for end in ends]
        axes.plot(ends, angles, color=_PUBLISHED, label="published ends, linear between")
    axes.plot(points[1].relative_density, points[1].angle, "s", color=_CHOSEN, label="fitted", zorder=3)
    axes.set(
        xlabel="relative density", ylabel="peak friction angle [deg]", title="the ends are not fitted to"
    )
    axes.legend()


def _draw_packing(axes: "Axes", calibration: Calibration) -> None:
    relation, target = calibration.relation, calibration.target.relative_density
    axes.plot(relation.friction, relation.void_ratio, "o-", color=_MODEL)
    friction = relation.friction_for(target)
    voids = float(np.interp(friction, relation.friction, relation.void_ratio))
    axes.plot(friction, voids, "s", color=_CHOSEN, label=f"relative density {target:.2f}")
    axes.set(xlabel="friction while settling", ylabel="void ratio", title="how the discs settle")
    axes.legend()


def _draw_plate(axes: "Axes", calibration: Calibration) -> None:
    plate, law = calibration.plate, calibration.plate.fit()
    sinkage, pressure, spread = (np.array(one) for one in (plate.sinkage, plate.pressure, plate.spread))
    low, high = (pressure - spread) / 1e3, (pressure + spread) / 1e3
    axes.fill_between(1e3 * sinkage, low, high, color=_MODEL, alpha=0.25, label="deviation between beds")
    axes.plot(1e3 * sinkage, pressure / 1e3, color=_MODEL, label="mean")
    fitted = law.modulus * sinkage**law.exponent / 1e3
    axes.plot(1e3 * sinkage, fitted, "--", color=_CHOSEN, label=f"Bekker, n = {law.exponent:.2f}")
    axes.set(xlabel="sinkage [mm]", ylabel="pressure [kPa]", title="plate", ylim=(0, None))
    axes.legend()
