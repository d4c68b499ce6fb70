"""Rolling against braked and pushed: where soil goes, and how deep (section 4.1.2, Figs. 18-19)."""

from typing import TYPE_CHECKING

import numpy as np

from validation.page import Panel
from validation.statistics import Interval
from validation.suites.paper.curves import draw_directions
from validation.suites.paper.experiment import Experiment
from validation.suites.paper.found import Found
from validation.suites.paper.regions import WAYS, MovingSoil, moving_soil
from validation.suites.paper.shown import flow_of, picture_of
from validation.suites.paper.verdict import JUDGED, Told, Variant, difference

if TYPE_CHECKING:
    import xarray as xr

    from synth import Footage

MEASURE = f"{__name__}:measure"
WHEELS = {"rolling_wheel": "rolling", "pushed_wheel": "pushed"}
THRUST = (-1.0, 0.0)
"""Soil pushed to the left drives the vehicle to the right, in both scenes."""
_NUMBERS = ("along", "across", "resultant", "depth", "share")
_TOLD = (
    ("rolling", "along"),
    ("rolling", "across"),
    ("pushed", "along"),
    ("rolling", "resultant"),
    ("pushed", "resultant"),
)


def measure(footage: "Footage", flow: "xr.Dataset") -> "xr.Dataset":
    """Share of motion energy along thrust, directions and depth of the moving region, pair by pair."""
    import xarray as xr

    numbers: dict[str, list[float]] = {f"thrust_{way}_{name}": [] for way in WAYS for name in _NUMBERS}
    directions: dict[str, list[np.ndarray]] = {way: [] for way in WAYS}
    for pair in moving_soil(footage, flow):
        for way, region in pair.items():
            told, share = _told_of(region, 1e3 * footage.metres_per_pixel)
            for name, value in told.items():
                numbers[f"thrust_{way}_{name}"].append(value)
            directions[way].append(share)
    variables = {name: ("pair", values) for name, values in numbers.items()}
    spread = {
        f"thrust_{way}_directions": (("pair", "thrust_bin"), np.stack(shares))
        for way, shares in directions.items()
    }
    return xr.Dataset({**variables, **spread})


def _told_of(region: MovingSoil, millimetres: float) -> tuple[dict[str, float], np.ndarray]:
    """Numbers of one region, and shares of directions in 36 bins; NaN where nothing moves."""
    import soft

    displacement, moving = region.displacement, region.moving
    if not moving.any():
        return dict.fromkeys(_NUMBERS, np.nan), np.full(36, np.nan)
    shares = soft.thrust_shares(displacement, moving, direction=THRUST)
    directions = soft.direction_statistics(displacement, moving)
    depth = soft.failure_depth(moving, region.soil).depth * millimetres
    share = float(moving.sum() / region.soil.sum())
    values = (shares.along, shares.across, directions.resultant_length, depth, share)
    return dict(zip(_NUMBERS, values, strict=True)), directions.share


def _tell(found: Found, variant: Variant) -> list[Told]:
    mean, true = (_means(found, variant, way) for way in ("measured", "true"))
    told = [
        Told(f"{name}_{wheel}", mean[wheel, name], truth=true[wheel, name].value)
        for wheel, name in _TOLD
        if mean[wheel, name].pair_count
    ]
    for name in ("along", "depth"):
        if all(mean[wheel, name].pair_count for wheel in WHEELS.values()):
            measured, truth = (difference(own["pushed", name], own["rolling", name]) for own in (mean, true))
            told.append(Told(f"{name}_difference", measured, truth=truth.value))
    return told


def _means(found: Found, variant: Variant, way: str) -> dict[tuple[str, str], Interval]:
    """Every number of both wheels."""
    return {
        (wheel, name): _mean(found, scene, variant, way, name)
        for scene, wheel in WHEELS.items()
        for name in _NUMBERS
    }


def _mean(found: Found, scene: str, variant: Variant, way: str, name: str) -> Interval:
    return found.mean(scene, variant, f"thrust_{way}_{name}")


def _draw(found: Found) -> list[Panel]:
    import soft

    shown = {
        wheel: one
        for scene, wheel in WHEELS.items()
        if (one := found.first(scene, JUDGED, having="shown_picture")) is not None
    }
    panels = []
    if len(shown) == len(WHEELS):
        runs = [(wheel.capitalize(), flow_of(one), picture_of(one)) for wheel, one in shown.items()]
        caption = (
            "Speed, above, and direction, below. The rolling wheel drives clockwise and travels to the "
            "right; the braked one is pushed to the left. Speeds have scales of their own."
        )
        panels.append(
            Panel.of(
                "Figures 18 and 19: two ways of failing", caption, soft.comparison_figure(runs), wide=True
            )
        )
    spreads = {
        wheel: {way: _directions(found, scene, way) for way in ("measured", "true")}
        for scene, wheel in WHEELS.items()
        if found.first(scene, JUDGED, having="thrust_measured_directions") is not None
    }
    if spreads:
        caption = "Directions of the moving soil, every pixel counting alike, mean of all pairs."
        panels.append(Panel.of("Directions", caption, draw_directions(spreads)))
    return panels


def _directions(found: Found, scene: str, way: str) -> np.ndarray:
    parts = found.measurements(scene, JUDGED)
    return np.nanmean(np.concatenate([one[f"thrust_{way}_directions"].values for one in parts]), axis=0)


def _find(found: Found) -> list[str]:
    sentences = []
    for scene, wheel in WHEELS.items():
        told = {(way, name): _mean(found, scene, JUDGED, way, name) for way in WAYS for name in _NUMBERS}
        if not told["measured", "along"].pair_count:
            continue
        along, depth = (
            [told[way, name].value for way in ("measured", "mode", "true")] for name in ("along", "depth")
        )
        sentences.append(
            f"{wheel.capitalize()}: {along[0]:.2f} of the motion energy is along thrust as measured, "
            f"{along[2]:.2f} in truth ({along[1]:.2f} with the camera's motion by what most soil shares); "
            f"the moving region is {depth[0]:.0f} mm deep, {depth[2]:.0f} mm in truth ({depth[1]:.0f} mm). "
            f"{told['true', 'share'].value:.0%} of the soil in view moves."
        )
    return sentences


EXPERIMENT = Experiment(
    name="thrust",
    title="Rolling against braked and pushed",
    figures="Figs. 18-19, section 4.1.2",
    about=(
        "The two halves of push-rolling. Under a rolling wheel soil fails close to the rim, all around it "
        "(Bekker's grip failure); a braked wheel that is pushed moves one mass in one direction (ground "
        "failure). All numbers are of the moving region that the clustering finds, from the measurement "
        "alone; the same of the truth stands below."
    ),
    table="paper_thrust",
    quantities=(
        "along_rolling",
        "across_rolling",
        "along_pushed",
        "along_difference",
        "resultant_rolling",
        "resultant_pushed",
        "depth_difference",
    ),
    tell=_tell,
    draw=_draw,
    find=_find,
    causes={
        ("along_pushed", "below"): (
            "loose soil sinks under the load as it is pushed, and rises ahead; and where much of the soil "
            "in view moves, its median is not quite the camera's motion"
        ),
        ("resultant_pushed", "below"): "the pushed mass rises at its fore and sinks at its rear",
        ("depth_difference", "below"): (
            "where the median over soil is not the camera's motion, the clustering cuts the pushed mass short"
        ),
        ("across_rolling", "below"): "less than a fifth of the motion is vertical",
    },
)
