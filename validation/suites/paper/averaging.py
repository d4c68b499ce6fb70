"""Averages over 1 to 100 pairs, under a rigid and a compliant wheel (section 3.3, Figs. 12-13)."""

from typing import TYPE_CHECKING

import numpy as np

from validation.page import Panel
from validation.pair_view import true_motion
from validation.scoring.averaging import AveragingTally
from validation.scoring.strata import distance_to
from validation.scoring.truth_pass import pass_over
from validation.statistics import Interval
from validation.suites.paper.curves import draw_gains
from validation.suites.paper.experiment import Experiment
from validation.suites.paper.found import Found, mean_of
from validation.suites.paper.shown import DIMS, flow_of, mean_flow_of, picture_of, rounded
from validation.suites.paper.verdict import JUDGED, Told, Variant, ratio

if TYPE_CHECKING:
    import xarray as xr

    from synth import Footage
    from validation.scoring.truth_pass import TruePair

MEASURE = f"{__name__}:measure"
RIGID, COMPLIANT = "rolling_wheel", "compliant_wheel"
WHEELS = {RIGID: "rigid", COMPLIANT: "compliant"}
_TOP = 99.0
_OFF_THE_RIM = 5.0
"""px; nearer to the soil's outline, flow may be the wheel's."""


def measure(footage: "Footage", flow: "xr.Dataset") -> "xr.Dataset":
    """Average over all pairs; tell what that gains by the data alone and against the truth."""
    import xarray as xr

    import soft

    mean = soft.average_flow(flow)
    tally, truth = AveragingTally(), _TrueMotion()
    if AveragingTally.suits(flow):
        pass_over(footage, {"this": flow}, {"this": [tally, truth]})
    score = tally.result()
    if score is None:
        return xr.Dataset()
    gain, moving = mean.gain, flow["moving"]
    found = [bool(moving.isel(pair=pair).values.any()) for pair in range(flow.sizes["pair"])]
    return xr.Dataset(
        {
            "averaging_u": (DIMS, rounded(mean.u)),
            "averaging_v": (DIMS, rounded(mean.v)),
            "averaging_true_count": ("averaging_level", list(score.pair_count)),
            "averaging_true_error": ("averaging_level", list(score.error)),
            "averaging_count": ("averaging_own_level", gain.pair_count),
            "averaging_gain": ("averaging_own_level", gain.gain),
            "averaging_found": ("pair", np.array(found, float)),
            "averaging_mean_found": float(mean.moving_region().found),
            "averaging_speed": _top_speed(mean.u, mean.v),
            "averaging_true_speed": _top_speed(*truth.mean()),
            "averaging_pair_speed": ("pair", truth.speeds),
        }
    )


class _TrueMotion:
    """True inertial motion of soil over all pairs: its mean, and the speed of each pair.

    Attributes
    ----------
    speeds : list of float
        What 1 % of the soil exceeds in each pair, px.
    """

    def __init__(self) -> None:
        self.speeds: list[float] = []
        self._total, self._count = np.zeros(0), np.zeros(0)

    def add(self, true: "TruePair", flow: "xr.Dataset") -> None:
        """Add one pair; the flow does not matter."""
        motion = true_motion(true.data, true.strata)
        self.speeds.append(_top_speed(motion.u, motion.v))
        vectors = np.stack([motion.u, motion.v]).astype(np.float64)
        known = np.isfinite(vectors).all(axis=0)
        self._total = np.where(known, vectors, 0.0) + (self._total if self._total.size else 0.0)
        self._count = known.astype(float) + (self._count if self._count.size else 0.0)

    def mean(self) -> np.ndarray:
        """Averaged over all pairs, (2, H, W) px; NaN where there was none."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(self._total / self._count)


def _top_speed(u: np.ndarray, v: np.ndarray) -> float:
    """Speed that 1 % of the soil exceeds, px, away from the soil's outline."""
    speed = np.hypot(u, v)
    inside = np.isfinite(speed) & (distance_to(~np.isfinite(speed)) > _OFF_THE_RIM)
    return float(np.percentile(speed[inside], _TOP)) if inside.any() else np.nan


def _tell(found: Found, variant: Variant) -> list[Told]:
    rigid, soft_rim = (_parts(found, scene, variant) for scene in (RIGID, COMPLIANT))
    told = []
    if rigid and rigid[0].sizes["averaging_level"] > 1:
        told.append(Told("lost", _lost(rigid)))
    if rigid and soft_rim:
        measured, true = (
            ratio(*(_mean(own, f"averaging_{way}speed") for own in (soft_rim, rigid)))
            for way in ("", "true_")
        )
        told.append(Told("compliant_over_rigid", measured, truth=true.value))
    if soft_rim:
        told.append(Told("compliant_single", mean_of([one["averaging_found"].values for one in soft_rim])))
        told.append(Told("compliant_average", _mean(soft_rim, "averaging_mean_found")))
    return told


def _mean(parts: "list[xr.Dataset]", name: str) -> Interval:
    """Of a number that a realisation has one of."""
    return mean_of([np.atleast_1d(one[name].values) for one in parts])


def _parts(found: Found, scene: str, variant: Variant) -> "list[xr.Dataset]":
    return [one for one in found.measurements(scene, variant) if "averaging_speed" in one]


def _lost(parts: "list[xr.Dataset]") -> Interval:
    """Share of the ideal gain that means over most pairs lose, by the truth."""
    lost = []
    for one in parts:
        count, error = (one[f"averaging_true_{name}"].values for name in ("count", "error"))
        lost.append(np.array([1 - error[0] / error[-1] / np.sqrt(count[-1])]))
    return mean_of(lost)


def _draw(found: Found) -> list[Panel]:
    import soft

    panels = []
    for number, (scene, wheel) in zip((12, 13), WHEELS.items(), strict=True):
        one = found.first(scene, JUDGED, having="shown_picture")
        if one is None or "averaging_u" not in one:
            continue
        figure = soft.average_figure(flow_of(one), mean_flow_of(one), picture_of(one))
        caption = (
            f"Soil speed under the {wheel} wheel: a single pair, and the average over all, on one scale."
        )
        panels.append(Panel.of(f"Figure {number}: {wheel} wheel", caption, figure))
    curves = {
        wheel: one
        for scene, wheel in WHEELS.items()
        if (one := found.first(scene, JUDGED, having="averaging_true_error")) is not None
    }
    if curves:
        caption = (
            "Root mean square error of means over N pairs, against the mean truth, all soil. Dashed: "
            "falling as one over the square root of N, as independent errors would."
        )
        panels.append(Panel.of("Noise against the number of pairs", caption, draw_gains(curves)))
    return panels


def _find(found: Found) -> list[str]:
    sentences = []
    for scene, wheel in WHEELS.items():
        one = found.first(scene, JUDGED, having="averaging_true_error")
        if one is None:
            continue
        count, error = (one[f"averaging_true_{name}"].values for name in ("count", "error"))
        gain, ideal = error[0] / error[-1], np.sqrt(count[-1])
        sentences.append(
            f"Under the {wheel} wheel, means over {count[-1]} pairs err by {error[-1]:.3f} px instead of "
            f"{error[0]:.3f} px: a gain of {gain:.1f} where independent errors would give {ideal:.1f}. "
            f"The true soil speed there is {float(one['averaging_true_speed']):.2f} px a pair, "
            f"{float(one['averaging_speed']):.2f} px by the measured mean."
        )
    return sentences


EXPERIMENT = Experiment(
    name="averaging",
    title="Signal averaging",
    figures="Figs. 12-13, section 3.3",
    about=(
        "Vectors averaged over successive pairs in the wheel's frame. Soil speed is what 1 % of the soil "
        "exceeds, in the average, 5 px and more from the soil's outline."
    ),
    table="paper_averaging",
    quantities=("lost", "compliant_over_rigid", "compliant_single", "compliant_average"),
    tell=_tell,
    draw=_draw,
    find=_find,
    causes={
        ("lost", "below"): (
            "more than the square root of N is gained: successive pairs share a picture, whose noise "
            "comes into both with opposite signs and goes out of their sum; the authors reckoned with "
            "independent errors"
        ),
        ("lost", "above"): "errors of the method that are alike in every pair do not average out",
        ("compliant_over_rigid", "above"): (
            "how soft the authors' wheel was is not told; ours flattens by 30 % of its radius and moves "
            "more soil"
        ),
        (
            "compliant_over_rigid",
            "below",
        ): "how soft the authors' wheel was is not told; ours moves less soil",
        ("compliant_single", "above"): "single pairs do show moving soil",
        (
            "compliant_average",
            "below",
        ): "the average over these pairs is still too noisy, or too little soil moves",
    },
)
