"""What the suite `paper` looks at, and with how many pairs: `soft-2014` takes some ten seconds each."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from validation.suites.paper import averaging, bucket, piv, rotation, shown, sift, speed, thrust
from validation.suites.paper.verdict import JUDGED
from validation.suites.plan import Look, Motion, Realisation, Suite

if TYPE_CHECKING:
    from validation.suites.execution import Failure

SEVERITIES = (JUDGED.severity, "clean")
METHODS = (JUDGED.method, "robust-affine")


@dataclass(frozen=True)
class Series:
    """Pictures of one scene.

    Attributes
    ----------
    scene : str
    pair_counts : (int, int)
        At severity `paper` and on clean pictures.
    quick_pair_counts : (int, int)
        The same of the quick suite.
    further : tuple of str
        What is measured besides errors.
    first : int
        Frame of the recording that they start at.
    seeds, picture_seeds : tuple of int
        Of the motion, and of its pictures.
    """

    scene: str
    pair_counts: tuple[int, int]
    quick_pair_counts: tuple[int, int]
    further: tuple[str, ...]
    first: int = 0
    seeds: tuple[int, ...] = (1,)
    picture_seeds: tuple[int, ...] = (0,)


# Longest first, so that no process is left with a long one at the end.
SERIES = (
    Series("bucket", (16, 8), (4, 1), (bucket.MEASURE,)),
    Series("rolling_wheel", (100, 8), (8, 1), (averaging.MEASURE, sift.MEASURE, thrust.MEASURE)),
    Series("compliant_wheel", (100, 8), (8, 1), (averaging.MEASURE,)),
    Series("constant_speed", (50, 8), (8, 1), (speed.MEASURE,)),
    Series("pushed_wheel", (14, 8), (4, 1), (thrust.MEASURE,), first=2),
    *(
        Series(plate, (1, 1), (1, 1), (rotation.MEASURE,), seeds=(1, 2), picture_seeds=(0, 1, 2, 3))
        for plate in rotation.PLATES
    ),
)


class PaperSuite(Suite):
    """A suite whose looks also measure what the experiments need; PIV looks at the plate."""

    def write_own_page(self, out: Path, failures: "Sequence[Failure]", *, command: str) -> dict[str, Any]:
        """Experiment by experiment, with the verdicts."""
        from validation.suites.paper.results import conclude

        return conclude(self, out, failures, command=command)

    def _looks_at(self, realisation: Realisation) -> list[Look]:
        further = _FURTHER[realisation.motion.scene]
        if realisation.picture_seed == 0:
            further = (shown.MEASURE, *further)
        looks = [Look(realisation, method, further=further) for method in self.methods]
        if realisation.motion.scene == piv.SCENE:
            looks += [Look(realisation, method) for method in piv.METHODS.values()]
        return looks


_FURTHER = {series.scene: series.further for series in SERIES}


def paper_suite(quick: bool) -> PaperSuite:
    """Every experiment; severity `paper` and clean."""
    realisations = tuple(one for series in SERIES for one in _realisations(series, quick))
    about = "the published numbers of the soil optical flow technique beside ours"
    return PaperSuite("paper", about, realisations, METHODS)


def _realisations(series: Series, quick: bool) -> list[Realisation]:
    counts = series.quick_pair_counts if quick else series.pair_counts
    seeds = series.seeds[:1] if quick else series.seeds
    return [
        Realisation(Motion(series.scene, seed, quick), picture_seed, severity, series.first, count)
        for seed in seeds
        for picture_seed in series.picture_seeds
        for severity, count in zip(SEVERITIES, counts, strict=True)
    ]
