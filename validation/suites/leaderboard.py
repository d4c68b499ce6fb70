"""The leaderboard: each method over all scenes of a suite at one severity, in the strata that matter."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from validation.statistics import Interval, StatisticsError, stratified_bootstrap
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
    median : dict
        For each of STRATA the median error, px, mean over scenes; an Interval.
    wrong : dict
        The same of the share of wrong pixels.
    better, worse : int
        Other methods and scenes that it is told to be better or worse than in complex flow.
    seconds : float
        Processor time of a picture pair.
    scene_count : int
        Scenes that it has seen.
    """

    method: str
    median: dict[str, Interval]
    wrong: dict[str, Interval]
    better: int
    worse: int
    seconds: float
    scene_count: int

    @property
    def decisive(self) -> Interval:
        """What methods are placed by: wrong pixels in complex flow; of all soil where no flow is complex."""
        return self.wrong.get("complex", self.wrong["all"])


def usual(lines: Iterable[Line], severity: str) -> list[Line]:
    """Lines of scenes as they usually are seen: no label, frame after frame."""
    return [line for line in lines if line["severity"] == severity and is_usual(line)]


def is_usual(line: Line) -> bool:
    """Whether a scene is seen as it is: what `Realisation.is_usual` tells."""
    return not line["label"] and line["stride"] == 1


def standings(lines: Sequence[Line], comparisons: Sequence[Comparison]) -> list[Standing]:
    """Methods by their share of wrong pixels in complex flow, the least first.

    Parameters
    ----------
    lines : sequence of dict
        Of one severity, see `usual`. Methods that saw fewer scenes than others come last.
    comparisons : sequence of Comparison
        Those of other scenes or severities are not counted.
    """
    groups = set(grouped(lines, GROUP))
    own = [one for one in comparisons if (one.scene, one.label, one.severity, one.stride) in groups]
    found = [_standing(method, part, own) for (method,), part in grouped(lines, ("method",)).items()]
    return sorted(found, key=lambda one: (-one.scene_count, one.decisive.value))


def _standing(method: str, lines: Sequence[Line], comparisons: Sequence[Comparison]) -> Standing:
    hard = [one for one in comparisons if one.stratum == "complex" and method in (one.first, one.second)]
    return Standing(
        method,
        _in_strata(lines, "median"),
        _in_strata(lines, WRONG),
        better=sum(one.better == method for one in hard),
        worse=sum(one.better not in (None, method) for one in hard),
        # The first pair a process looks at includes what it compiles.
        seconds=float(np.median([line["seconds"] for line in lines])),
        scene_count=len(grouped(lines, GROUP)),
    )


def _in_strata(lines: Sequence[Line], quantity: str) -> dict[str, Interval]:
    found = {}
    for stratum in STRATA:
        try:
            found[stratum] = over_scenes(lines, stratum, quantity)
        except StatisticsError:  # no scene has it
            continue
    return found


def over_scenes(lines: Iterable[Line], stratum: str, quantity: str) -> Interval:
    """Mean over scenes, each counted alike. Scenes are given; what is drawn anew is their simulations.

    Raises
    ------
    StatisticsError
        No line has such a number.
    """
    own = [line for line in lines if line["stratum"] == stratum]
    return stratified_bootstrap(_simulations(own, quantity), block_length=BLOCK)[0]


def difference_over_scenes(
    first: Iterable[Line], second: Iterable[Line], quantity: str, *, within: Sequence[str] = GROUP
) -> tuple[Interval, float]:
    """How much two sets of lines differ on the same pictures: mean over scenes, and its probability.

    Parameters
    ----------
    first, second : iterable of dict
        Lines of one stratum.
    quantity : str
        A column.
    within : sequence of str
        Columns that tell scenes apart; those in which the two sets differ are left out.

    Raises
    ------
    StatisticsError
        They have no picture in common.
    """
    known = {_picture(line, within): line[quantity] for line in second}
    differences = [
        {**line, "difference": line[quantity] - known[_picture(line, within)]}
        for line in first
        if _picture(line, within) in known
    ]
    return stratified_bootstrap(_simulations(differences, "difference", within), block_length=BLOCK)


def _picture(line: Line, within: Sequence[str]) -> tuple:
    return *(line[name] for name in within), line["seed"], line["picture_seed"], line["pair"]


def _simulations(
    lines: Iterable[Line], quantity: str, within: Sequence[str] = GROUP
) -> list[list[np.ndarray]]:
    """For each scene, the numbers of each of its simulations, all pictures of it together."""
    return [
        [np.array([line[quantity] for line in own], np.float64) for own in grouped(scene, ("seed",)).values()]
        for scene in grouped(lines, within).values()
    ]
