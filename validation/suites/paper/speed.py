"""Constant horizontal speed: the camera's motion, told from soil that rests (section 3.1.2, Fig. 10)."""

from typing import TYPE_CHECKING

import numpy as np

from validation.page import Panel
from validation.published import read_published
from validation.statistics import NORMAL_95, Interval
from validation.suites.paper.curves import draw_camera
from validation.suites.paper.experiment import Experiment
from validation.suites.paper.found import Found, mean_of
from validation.suites.paper.shown import flow_of, picture_of
from validation.suites.paper.verdict import JUDGED, Told, Variant

if TYPE_CHECKING:
    import xarray as xr

    from synth import Footage

MEASURE = f"{__name__}:measure"
SCENE = "constant_speed"
_MINOR = 0.5
"""Share of the published range below which the flow's part is the lesser one."""


def measure(footage: "Footage", flow: "xr.Dataset") -> "xr.Dataset":
    """Keep the camera's motion of every pair: as measured, true, and as the true motion of soil gives it."""
    import xarray as xr

    truths = footage.truths.isel(pair=slice(flow.sizes["pair"]))
    told = {
        "speed_measured": flow["camera_u"].values,
        "speed_true": truths["camera_u"].values,
        "speed_by_soil": [_by_true_soil(footage, pair) for pair in range(flow.sizes["pair"])],
    }
    scale = 100 * footage.metres_per_pixel * footage.frame_rate
    return xr.Dataset(
        {name: ("pair", np.asarray(values, np.float64)) for name, values in told.items()},
        attrs={"speed_scale": scale},
    )


def _by_true_soil(footage: "Footage", pair: int) -> float:
    """Give the camera's motion as the median true displacement of soil tells it, px."""
    from validation.scoring.truth_pass import TruePair

    return TruePair(footage.truth(pair).load()).camera_by_soil("median")


def _tell(found: Found, variant: Variant) -> list[Told]:
    parts = [one for one in found.measurements(SCENE, variant) if "speed_measured" in one]
    if not parts:
        return []
    measured = [one["speed_measured"].values for one in parts]
    # Resting soil goes to the left where the camera goes to the right.
    speeds = [-one["speed_measured"].values * one.attrs["speed_scale"] for one in parts]
    flow_errors = [(one["speed_measured"] - one["speed_by_soil"]).values for one in parts]
    true = [-one["speed_true"].values * one.attrs["speed_scale"] for one in parts]
    spread, flow_spread = variance_of(measured), variance_of(flow_errors)
    true_spread = _range_of(variance_of([one["speed_true"].values for one in parts]))
    return [
        Told("speed", mean_of(speeds), truth=mean_of(true).value),
        Told("range", _range_of(spread), truth=true_spread.value),
        Told("flow_share", _scaled(flow_spread, 1 / spread.value if spread.value else np.nan)),
    ]


def variance_of(realisations: list[np.ndarray]) -> Interval:
    """Variance over the pairs of a realisation, with its interval."""
    squares = [
        np.square(one - one.mean()) * len(one) / (len(one) - 1) for one in realisations if len(one) > 1
    ]
    return mean_of(squares)


def _range_of(variance: Interval) -> Interval:
    value, low, high = (
        NORMAL_95 * float(np.sqrt(max(part, 0.0))) for part in (variance.value, variance.low, variance.high)
    )
    return Interval(value, low, high, variance.realisation_count, variance.pair_count)


def _scaled(one: Interval, factor: float) -> Interval:
    ends = (one.value * factor, one.low * factor, one.high * factor)
    return Interval(*ends, one.realisation_count, one.pair_count)


def _draw(found: Found) -> list[Panel]:
    import soft

    panels = []
    if (shown := found.first(SCENE, JUDGED, having="shown_picture")) is not None:
        figure = soft.speed_figure(flow_of(shown), picture_of(shown))
        caption = "Soil speed of one pair with the camera's motion taken out; most soil rests."
        panels.append(Panel.of("Figure 10: one pair of pictures", caption, figure))
    if (series := found.first(SCENE, JUDGED, having="speed_measured")) is not None:
        caption = (
            "Dots: told by the median over soil, a pair each. Line: the carriage's true motion. Shaded: "
            "what the authors' rig showed, 7.23 ± 0.34 px (our scale makes 0.8 cm/s 7.23 px)."
        )
        panels.append(Panel.of("The camera's motion, pair by pair", caption, draw_camera(series)))
    return panels


def _find(found: Found) -> list[str]:
    parts = [one for one in found.measurements(SCENE, JUDGED) if "speed_measured" in one]
    if not parts:
        return []
    names = ("speed_measured", "speed_by_soil"), ("speed_by_soil", "speed_true"), ("speed_true", None)
    spreads = [
        _range_of(variance_of([(one[a] - one[b] if b else one[a]).values for one in parts])).value
        for a, b in names
    ]
    bias = float(np.mean([(one["speed_measured"] - one["speed_true"]).mean() for one in parts]))
    flow, soil, rig = spreads
    told = (
        f"The flow's error makes ± {flow:.3f} px of it, soil that does not rest ± {soil:.3f} px, the "
        f"carriage itself ± {rig:.3f} px; the mean is off by {bias:+.3f} px."
    )
    published = read_published("paper_speed")["range"].value
    if flow < _MINOR * published:
        told += (
            f" A median over hundreds of thousands of pixels hardly errs: the published ± {published:g} px "
            "is as large as a single pixel's error, but need not come from it, as the authors suggest; "
            "drive, vibration, clock and soil that moves make more of it than the flow."
        )
    return [told]


EXPERIMENT = Experiment(
    name="speed",
    title="Constant horizontal speed",
    figures="Fig. 10, section 3.1.2",
    about=(
        "A wheel at 20 % slip, the camera on its carriage. Resting soil goes through the picture at the "
        "carriage's speed, 0.8 cm/s; the median horizontal motion over soil tells it. Our carriage moves "
        "exactly."
    ),
    table="paper_speed",
    quantities=("speed", "range", "flow_share"),
    tell=_tell,
    draw=_draw,
    find=_find,
    causes={
        (
            "range",
            "below",
        ): "our carriage, camera and clock are exact: the authors' range holds those of a rig",
        ("range", "above"): "more soil in view moves than in the authors' pictures",
        ("flow_share", "below"): (
            "a median over so many pixels hardly errs: what varies is how much of the soil in view rests"
        ),
    },
)
