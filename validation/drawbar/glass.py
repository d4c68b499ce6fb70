"""The two halves of push-rolling through the glass, beside the rover's forces: grip and ground failure.

A run of the rolling wheel and one of the braked wheel pushed backwards, the same wheel in the same soil,
analyzed as pictures (the paper's Figs. 18, 19): where soil moves to, and how much of its motion is along
thrust, as measured and in truth. Beside it, what the rolling and the standing axle of the rover thrust.
"""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from synth.rover.drawbar import DrawbarPoint
from validation.drawbar.curve import Curve

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from xarray import Dataset

    from synth.scene import SoilBinScene

ROLLING, PUSHED = "rolling", "pushed"
_DRIVES = {"rolling": ROLLING, "pushing": PUSHED}
_WAYS = {"measured": "#4c78a8", "true": "#f58518"}
_STANDING = {"expand": "rear", "contract": "front"}


class GlassError(ValueError):
    """Runs that do not show what is wanted; the message names the run and what is allowed."""


@dataclass(frozen=True)
class Seen:
    """Motion of soil through the glass, mean over pairs.

    Attributes
    ----------
    along, across : float
        Share of the motion energy along and across thrust.
    resultant : float
        Length of the mean of all directions: 1 where all soil moves one way.
    depth : float
        Of the moving region, mm.
    directions : ndarray, shape (36,)
        Share of moving pixels a 10 degrees, from -180 (left) on.
    """

    along: float
    across: float
    resultant: float
    depth: float
    directions: NDArray


@dataclass(frozen=True)
class GlassView:
    """A wheel's run.

    Attributes
    ----------
    wheel : str
        `ROLLING` or `PUSHED`.
    thrust : float
        Mean horizontal force of the soil on the wheel / load, while it is seen.
    seen : dict of Seen
        As `measured` and `true`.
    """

    wheel: str
    thrust: float
    seen: dict[str, Seen]


def runs_by_wheel(runs: Sequence[Path]) -> dict[str, Path]:
    """Which run is of which wheel, the rolling one first; their pictures are opened, not yet analyzed.

    Raises
    ------
    GlassError
        One is no run of a rolling or of a pushed wheel, both are of the same, or either is missing.
    """
    found: dict[str, Path] = {}
    for run in runs:
        wheel = _wheel_of(run)
        if wheel in found:
            raise GlassError(f"--glass: {found[wheel]} and {run} are both runs of a {wheel} wheel")
        found[wheel] = run
    if set(found) != {ROLLING, PUSHED}:
        raise GlassError(f"--glass: a run of a rolling and one of a pushed wheel are needed, not {len(runs)}")
    return {wheel: found[wheel] for wheel in (ROLLING, PUSHED)}


def _wheel_of(run: Path) -> str:
    import soft
    from synth import Footage

    for needed in ("scene.toml", "footage", "forces.csv"):
        if not (run / needed).exists():
            raise GlassError(f"{run}: no {needed}: a run folder of softbed is needed")
    scene = _scene_of(run)
    soft.ImageSequence.open(run / "footage")
    Footage.open(run / "footage").close()
    return _DRIVES[scene.drive.kind]


def _scene_of(run: Path) -> "SoilBinScene":
    from synth.scene import SoilBinScene, load_scene

    scene = load_scene(run / "scene.toml")
    if not isinstance(scene, SoilBinScene) or scene.drive.kind not in _DRIVES:
        raise GlassError(f"{run}: allowed are runs of a rolling and of a pushed wheel")
    return scene


def look(run: Path) -> GlassView:
    """Analyze the pictures of a run by the default method; `runs_by_wheel` has found that it is one."""
    import soft
    from synth import Footage
    from validation.identification.runs import Forces
    from validation.suites.paper.thrust import measure

    scene = _scene_of(run)
    pictures = soft.ImageSequence.open(run / "footage")
    with Footage.open(run / "footage") as footage, soft.analyze(pictures, threads=1) as flow:
        measured = measure(footage, flow)
    forces = Forces.read(run / "forces.csv")
    load = scene.implement.normal_load  # type: ignore[union-attr]
    thrust = float(forces.force_x[forces.time > 0].mean() / load)
    return GlassView(_DRIVES[scene.drive.kind], thrust, {way: _seen(measured, way) for way in _WAYS})


def _seen(measured: "Dataset", way: str) -> Seen:
    numbers = {
        name: float(np.nanmean(measured[f"thrust_{way}_{name}"].values))
        for name in ("along", "across", "resultant", "depth")
    }
    directions = np.nanmean(measured[f"thrust_{way}_directions"].values, axis=0)
    return Seen(**numbers, directions=directions)


def glass_figure(views: dict[str, GlassView], curves: Sequence[Curve]) -> "Figure":
    """Directions of moving soil above; below its share along thrust, and who thrusts on the rover."""
    from matplotlib.figure import Figure

    from soft.figures.page import plain_axes

    figure = Figure(figsize=(8.4, 7.4), layout="constrained")
    roses, bars = figure.subfigures(2, 1, height_ratios=(1.25, 1))  # type: ignore[misc]
    every = roses.subplots(1, len(views), subplot_kw={"projection": "polar"})
    for axes, view in zip(every, views.values(), strict=True):
        _draw_rose(axes, view)
    every[0].legend(frameon=False, fontsize=8, loc="lower left", bbox_to_anchor=(-0.3, -0.1))
    left, right = bars.subplots(1, 2)
    _draw_shares(plain_axes(left), views)
    _draw_thrust(plain_axes(right), views, curves)
    return figure


def write_glass_table(views: dict[str, GlassView], path: Path) -> None:
    """Write the numbers, one line for each wheel and way."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(
            ["wheel", "way", "along_thrust", "across_thrust", "resultant", "depth_mm", "thrust_over_load"]
        )
        for view in views.values():
            for way, seen in view.seen.items():
                numbers = (seen.along, seen.across, seen.resultant, seen.depth, view.thrust)
                writer.writerow([view.wheel, way, *(f"{number:.4g}" for number in numbers)])


def _draw_rose(axes: "Axes", view: GlassView) -> None:
    for way, colour in _WAYS.items():
        share = 100 * view.seen[way].directions
        edges = np.linspace(-np.pi, np.pi, share.size + 1)
        middle = (edges[:-1] + edges[1:]) / 2
        if way == "measured":
            axes.bar(middle, share, np.diff(edges), color=colour, alpha=0.75, label=way)
        else:
            ring = np.append(np.arange(share.size), 0)
            axes.plot(middle[ring], share[ring], color=colour, linewidth=1.6, label=way)
    axes.set_xticks(np.arange(4) * np.pi / 2, ["right", "up", "left\n(thrust)", "down"], fontsize=8)
    axes.tick_params(labelsize=7)
    axes.yaxis.get_major_locator().base.set_params(nbins=4)  # type: ignore[attr-defined]
    told = {ROLLING: "rolling: grip failure", PUSHED: "braked and pushed: ground failure"}
    axes.set_title(f"{told[view.wheel]}\nmoving soil, pixels a 10 degrees [%]", fontsize=9)


def _draw_shares(axes: "Axes", views: dict[str, GlassView]) -> None:
    place = np.arange(len(views))
    for offset, (way, colour) in zip((-0.2, 0.2), _WAYS.items(), strict=True):
        values = [view.seen[way].along for view in views.values()]
        axes.bar(place + offset, values, 0.38, color=colour, label=way)
    axes.set_xticks(place, list(views), fontsize=9)
    axes.set_ylim(0, 1)
    axes.set_title("share of the soil's motion energy along thrust", fontsize=9)
    axes.legend(frameon=False, fontsize=8, loc="upper left")


def _draw_thrust(axes: "Axes", views: dict[str, GlassView], curves: Sequence[Curve]) -> None:
    """Horizontal force over load of the axle that rolls and of the one that stands, against the pull."""
    for curve in curves:
        if curve.order.gait != "inching":
            continue
        pulls = [point.drawbar_pull_ratio for point in curve.moving]
        style = "-" if curve.order.wheel == "rigid" else "--"
        for stands, colour in ((False, "#4c78a8"), (True, "#e45756")):
            thrust = [thrust_over_load(point, stands) for point in curve.moving]
            told = "stands" if stands else "rolls"
            axes.plot(pulls, thrust, style, color=colour, label=f"axle that {told}, {curve.order.wheel}")
    level = axes.get_yaxis_transform()
    for view, colour in zip(views.values(), ("#4c78a8", "#e45756"), strict=True):
        axes.axhline(view.thrust, color=colour, linewidth=0.8, linestyle=":")
        axes.annotate(
            f"seen wheel, {view.wheel}", (1, view.thrust), xycoords=level, fontsize=7, color=colour,
            va="bottom", ha="right",
        )  # fmt: skip
    axes.axhline(0, color="black", linewidth=0.6)
    axes.set_xlabel("drawbar pull / vehicle weight", fontsize=9)
    axes.set_title("horizontal force of the soil / load, inching", fontsize=9)
    axes.legend(frameon=False, fontsize=7, loc="upper left")


def thrust_over_load(point: DrawbarPoint, stands: bool) -> float:
    """Of the axles that stand, or of those that roll, over both phases of an inching cycle."""
    along = upward = 0.0
    for phase in point.phases:
        for wheel in phase.wheels:
            if wheel.wheel.startswith(_STANDING[phase.phase]) == stands:
                along += wheel.force_x * phase.duration
                upward += wheel.force_z * phase.duration
    return along / upward
