"""The suites there are.

Their seeds are none that a method of this project was tuned on (101) or that tables in the docs were made
with (0).
"""

from collections.abc import Callable
from dataclasses import replace

from validation.suites.anchor import anchor_suite
from validation.suites.paper.plan import paper_suite
from validation.suites.plan import Motion, Realisation, Suite

SEEDS = (1, 2)
PICTURE_SEEDS = (0, 1, 2, 3)
DENSE = ("robust-affine", "dis", "farneback", "tvl1", "ilk")
SLOW = ("black-anandan",)
"""Take many times as long as the others: they see a part of the pictures."""
BIN_SCENES = (
    "rolling_wheel",
    "constant_speed",
    "pushed_wheel",
    "grouser_wheel",
    "compliant_wheel",
    "bucket",
    "fillite_wheel",
)


class SuiteError(ValueError):
    """A suite that does not exist; the message is one line."""


def find_suite(name: str, *, quick: bool = False) -> Suite:
    """Find a suite by name.

    Raises
    ------
    SuiteError
        There is none of this name.
    """
    if name not in SUITES:
        raise SuiteError(f"suite {name!r}: allowed are {', '.join(SUITES)}")
    return SUITES[name](quick)


def _smoke(quick: bool) -> Suite:
    motions = [Motion(scene, SEEDS[0], quick=True) for scene in ("plate_rotation", "shear_band")]
    pictures = tuple(Realisation(motion, seed, pair_count=1) for motion in motions for seed in (0, 1))
    return Suite(
        "smoke", "whether it all works: small pictures of motions by formula", pictures, ("dis", "farneback")
    )


def _complex(quick: bool) -> Suite:
    seeds, picture_seeds, pair_count = (SEEDS[:1], (0, 1), 2) if quick else (SEEDS, PICTURE_SEEDS, 4)
    motions = [Motion(scene, seed, quick) for scene in BIN_SCENES for seed in seeds]
    pictures = [
        Realisation(motion, picture_seed, pair_count=pair_count, first=2)
        for motion in motions
        for picture_seed in picture_seeds
    ]
    pictures += _variations(quick, seeds, picture_seeds)
    stars = [Motion("sinusoidal_strain", seed, quick) for seed in seeds]
    pictures += [Realisation(star, seed, pair_count=1) for star in stars for seed in picture_seeds]
    return Suite(
        "complex", "every implement, both soils: where flow is complex", tuple(pictures), DENSE, SLOW
    )


def _variations(quick: bool, seeds: tuple[int, ...], picture_seeds: tuple[int, ...]) -> list[Realisation]:
    """The rolling wheel seen otherwise: what is said of complex flow should not depend on it."""
    found = []
    for motion in (Motion("rolling_wheel", seed, quick) for seed in seeds):
        for picture_seed in picture_seeds:
            base = Realisation(motion, picture_seed, first=2, pair_count=2)
            found += [replace(base, stride=stride) for stride in ((2,) if quick else (2, 4))]
            found.append(replace(base, label="carried", changes=(("texture", "motion", "carried"),)))
            exchange = (0.1,) if quick else (0.05, 0.1, 0.2)
            found += [
                replace(base, label=f"exchange-{rate:g}", changes=(("nuisance", "exchange", rate),))
                for rate in exchange
            ]
    return found


SUITES: dict[str, Callable[[bool], Suite]] = {
    "smoke": _smoke,
    "paper": paper_suite,
    "complex": _complex,
    "anchor": anchor_suite,
}
