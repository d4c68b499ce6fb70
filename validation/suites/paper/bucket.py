"""A bucket that cuts horizontally: which way the pile goes (section 4.2, Fig. 20)."""

from typing import TYPE_CHECKING

import numpy as np

from validation.page import Panel
from validation.suites.paper.experiment import Experiment
from validation.suites.paper.found import Found
from validation.suites.paper.regions import WAYS, MovingSoil, moving_soil
from validation.suites.paper.shown import flow_of, picture_of
from validation.suites.paper.verdict import JUDGED, Told, Variant

if TYPE_CHECKING:
    import xarray as xr

    from synth import Footage

MEASURE = f"{__name__}:measure"
SCENE = "bucket"
_NUMBERS = ("forward", "fore_up", "rear_down")


def measure(footage: "Footage", flow: "xr.Dataset") -> "xr.Dataset":
    """Shares of the pile that go forward, up at its fore and down at its rear, pair by pair."""
    import xarray as xr

    told: dict[str, list[float]] = {f"bucket_{way}_{name}": [] for way in WAYS for name in _NUMBERS}
    for pair in moving_soil(footage, flow):
        for way, region in pair.items():
            for name, value in pile_shares(region).items():
                told[f"bucket_{way}_{name}"].append(value)
    return xr.Dataset({name: ("pair", values) for name, values in told.items()})


def pile_shares(region: MovingSoil) -> dict[str, float]:
    """Shares of pixels; the bucket is to the left of its pile and goes to the right. NaN where nothing moves.

    The fore is the third of the pile's pixels farthest to the right, the rear that farthest to the left.
    """
    known = region.moving & np.isfinite(region.displacement).all(axis=2)
    if not known.any():
        return dict.fromkeys(_NUMBERS, np.nan)
    column = np.nonzero(known)[1]
    u, v = region.displacement[known].T
    rear, fore = np.quantile(column, [1 / 3, 2 / 3])
    return {
        "forward": float((u > 0).mean()),
        "fore_up": float((v[column >= fore] < 0).mean()),
        "rear_down": float((v[column <= rear] > 0).mean()),
    }


def _tell(found: Found, variant: Variant) -> list[Told]:
    told = [
        Told(
            name,
            found.mean(SCENE, variant, f"bucket_measured_{name}"),
            truth=found.mean(SCENE, variant, f"bucket_true_{name}").value,
        )
        for name in _NUMBERS
    ]
    return [one for one in told if one.interval.pair_count]


def _draw(found: Found) -> list[Panel]:
    import soft

    shown = found.first(SCENE, JUDGED, having="shown_picture")
    if shown is None:
        return []
    figure = soft.bucket_figure(flow_of(shown), picture_of(shown))
    caption = "Our bucket cuts to the right, the authors' to the left."
    return [Panel.of("Figure 20: where the pile goes", caption, figure)]


def _find(found: Found) -> list[str]:
    true = {name: found.mean(SCENE, JUDGED, f"bucket_true_{name}") for name in _NUMBERS}
    if not true["forward"].pair_count:
        return []
    return [
        f"In truth, {true['forward'].value:.1%} of the pile goes forward, {true['fore_up'].value:.1%} of "
        f"its fore up, {true['rear_down'].value:.1%} of its rear down."
    ]


EXPERIMENT = Experiment(
    name="bucket",
    title="Excavation with a bucket",
    figures="Fig. 20, section 4.2",
    about=(
        "A bucket cuts at constant depth, and soil piles up ahead of it. Cut angle, depth and size of "
        "ours are assumed: the paper refers to another for them."
    ),
    table="paper_bucket",
    quantities=_NUMBERS,
    tell=_tell,
    draw=_draw,
    find=_find,
    causes={
        ("rear_down", "below"): (
            "the soil at our blade rises with the cut; how far the pile has grown, and the cut angle, decide"
        ),
        ("fore_up", "below"): "the fore of our pile avalanches",
        ("forward", "below"): "a part of the moving region falls back",
    },
)
