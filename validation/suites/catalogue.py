"""The suites there are.

Their seeds are none that a method of this project was tuned on (101) or that tables in the docs were made
with (0).
"""

from collections.abc import Callable

from validation.suites.anchor import anchor_suite
from validation.suites.complex_flow import complex_suite
from validation.suites.paper.plan import paper_suite
from validation.suites.plan import Motion, Realisation, Suite

SEED = 1


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
    motions = [Motion(scene, SEED, quick=True) for scene in ("plate_rotation", "shear_band")]
    pictures = tuple(Realisation(motion, seed, pair_count=1) for motion in motions for seed in (0, 1))
    return Suite(
        "smoke", "whether it all works: small pictures of motions by formula", pictures, ("dis", "farneback")
    )


SUITES: dict[str, Callable[[bool], Suite]] = {
    "smoke": _smoke,
    "paper": paper_suite,
    "complex": complex_suite,
    "anchor": anchor_suite,
}
