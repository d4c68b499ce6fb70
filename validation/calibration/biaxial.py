"""Peak friction angle of a sample that was prepared at a relative density."""

from dataclasses import dataclass

import numpy as np

from synth.cache import cached
from synth.dem.contact_law import ContactLaw, damping_ratio_of
from synth.dem.relative_density import DIAMETER, SIDE, SettlingRelation, settled_sample
from synth.soil import GrainContact
from validation.verification.biaxial import MODULUS, STRAIN_STEP, Compression, compress
from validation.verification.comparison import Progress
from validation.verification.packing import Box

RECIPE = 1
"""Raised when the test changes: older results in the cache are then left alone."""
END = 0.15
"""Strain that samples are compressed to: a peak comes before, and a loose sample has met its plateau."""
WINDOW = 0.01
"""Strain that stresses are averaged over before their greatest ratio is taken: what jerks is no strength."""


@dataclass(frozen=True)
class BiaxialPoint:
    """Samples of one relative density and one pair of frictions, one a seed.

    Attributes
    ----------
    friction, rolling_friction, relative_density : float
        What was asked for.
    sine : tuple of float
        Of the peak friction angle, by seed.
    void_ratio : tuple of float
        Under the confining pressure, before compression, by seed.
    """

    friction: float
    rolling_friction: float
    relative_density: float
    sine: tuple[float, ...]
    void_ratio: tuple[float, ...]

    @property
    def mean(self) -> float:
        """Mean sine."""
        return float(np.mean(self.sine))

    @property
    def deviation(self) -> float:
        """Standard deviation of the sine from seed to seed."""
        return float(np.std(self.sine, ddof=1)) if len(self.sine) > 1 else 0.0

    @property
    def angle(self) -> float:
        """Friction angle of the mean sine, deg."""
        return float(np.degrees(np.arcsin(self.mean)))

    @property
    def angle_error(self) -> float:
        """Standard error of that angle, deg."""
        error = self.deviation / np.sqrt(len(self.sine))
        return float(np.degrees(error / np.sqrt(1 - self.mean**2)))


def measure_point(
    contact: GrainContact,
    polydispersity: float,
    relation: SettlingRelation,
    *,
    relative_density: float,
    seeds: tuple[int, ...],
    progress: Progress,
) -> BiaxialPoint:
    """Prepare a sample for every seed, and compress it; what is in the cache is not done again.

    Parameters
    ----------
    relation : SettlingRelation
        Of these grains.
    """
    settling_friction = relation.friction_for(relative_density)
    found = []
    for part, seed in enumerate(seeds):
        found.append(_measured(contact, polydispersity, settling_friction, seed, progress, part, len(seeds)))
    return BiaxialPoint(
        contact.friction,
        contact.rolling_friction,
        relative_density,
        tuple(one["sine"] for one in found),
        tuple(one["void_ratio"] for one in found),
    )


def _measured(
    contact: GrainContact,
    polydispersity: float,
    settling_friction: float,
    seed: int,
    progress: Progress,
    part: int,
    parts: int,
) -> dict[str, float]:
    made_from = {
        "recipe": RECIPE,
        "side": SIDE,
        "end": END,
        "friction": contact.friction,
        "rolling_friction": contact.rolling_friction,
        "restitution": contact.restitution,
        "polydispersity": polydispersity,
        "settling_friction": settling_friction,
        "seed": seed,
    }

    def measure() -> dict[str, float]:
        poured = settled_sample(contact, polydispersity, friction=settling_friction, seed=seed)
        test = compress(
            poured,
            _law(contact),
            box=Box(SIDE * DIAMETER),
            end=END,
            progress=lambda done, total: progress(part * total + done, parts * total),
        )
        return {"sine": peak_sine(test), "void_ratio": test.void_ratio[0]}

    return cached("biaxial", made_from, measure)  # type: ignore[no-any-return]


def peak_sine(test: Compression) -> float:
    """Greatest sine of the mobilized friction angle, of means over `WINDOW`."""
    window = round(WINDOW / STRAIN_STEP)
    return float(np.convolve(test.sine, np.full(window, 1 / window), "valid").max())


def _law(contact: GrainContact) -> ContactLaw:
    """The soil's contacts at the test's stiffness; platens are smooth."""
    return ContactLaw(
        normal_stiffness=MODULUS,
        tangential_stiffness=0.5 * MODULUS,
        damping_ratio=damping_ratio_of(contact.restitution),
        friction=contact.friction,
        wall_friction=0.0,
        implement_friction=0.0,
        rolling_friction=contact.rolling_friction,
    )
