"""The leaderboard: each method over all scenes of a suite, in the strata that matter."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from validation.statistics import Interval, StatisticsError, block_bootstrap
from validation.suites.headline import BLOCK, GROUP, Comparison, grouped
from validation.suites.table import Line

STRATA = ("all", "moving", "complex")
WRONG = "wrong_0.3"


@dataclass(frozen=True)
class Standing:
    """One method's place.

    Attributes
    ----------
    method : str
    median : Interval
        Median error over all soil, px: mean over scenes.
    wrong : dict
        For each of STRATA the share of wrong pixels, mean over scenes; an Interval.
    better, worse : int
        Other methods and scenes that it is told to be better or worse than in complex flow.
    seconds : float
        A picture pair, on one thread.
    scene_count : int
        Scenes that it has seen.
    """

    method: str
    median: Interval
    wrong: dict[str, Interval]
    better: int
    worse: int
    seconds: float
    scene_count: int


def standings(lines: Sequence[Line], comparisons: Sequence[Comparison]) -> list[Standing]:
    """Methods by their share of wrong pixels in complex flow, the least first; of all soil without any."""
    found = [_standing(method, own, comparisons) for (method,), own in grouped(lines, ("method",)).items()]
    return sorted(found, key=_order)


def _order(standing: Standing) -> tuple[float, float]:
    shares = [standing.wrong[stratum].value for stratum in ("complex", "all") if stratum in standing.wrong]
    return -standing.scene_count, shares[0] if shares else np.inf


def _standing(method: str, lines: Sequence[Line], comparisons: Sequence[Comparison]) -> Standing:
    wrong = {}
    for stratum in STRATA:
        try:
            wrong[stratum] = _over_scenes(lines, stratum, WRONG)
        except StatisticsError:  # no scene has it
            continue
    hard = [one for one in comparisons if one.stratum == "complex" and method in (one.first, one.second)]
    return Standing(
        method,
        _over_scenes(lines, "all", "median"),
        wrong,
        better=sum(one.better == method for one in hard),
        worse=sum(one.better not in (None, method) for one in hard),
        seconds=float(np.mean([line["seconds"] for line in lines])),
        scene_count=len(grouped(lines, GROUP)),
    )


def _over_scenes(lines: Sequence[Line], stratum: str, quantity: str) -> Interval:
    """Mean over scenes; scenes are given, so that only realisations and frames are drawn anew.

    A scene's realisation is told by its seeds; realisations of the same seeds in several scenes are averaged
    first, pair by pair where all have it, so that each scene counts alike.
    """
    own = [line for line in lines if line["stratum"] == stratum]
    by_scene = grouped(own, GROUP)
    tables = [
        {(line["seed"], line["picture_seed"], line["pair"]): line[quantity] for line in part}
        for part in by_scene.values()
    ]
    tables = [table for table in tables if np.isfinite(list(table.values())).any()]
    pictures = sorted({key for table in tables for key in table})
    means = {key: _mean([table[key] for table in tables if key in table]) for key in pictures}
    realisations = grouped([{"of": key[:2], "value": value} for key, value in means.items()], ("of",))
    arrays = [np.array([one["value"] for one in part]) for part in realisations.values()]
    return block_bootstrap(arrays, block_length=BLOCK)


def _mean(values: list[float]) -> float:
    known = [value for value in values if np.isfinite(value)]
    return float(np.mean(known)) if known else float("nan")
