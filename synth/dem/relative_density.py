"""Relative density of discs: the void ratios between which they can be prepared, and how to reach one.

As in the laboratory, where a soil is poured loosest and shaken densest in a standard mould, discs are
settled in a standard bin: **densest without friction**, which is where shaking and compression end (grains
that do not rub slide until they are jammed), **loosest with the greatest friction** and the soil's own
resistance to rolling. Between the two, friction while settling sets the void ratio. Size of the grains, their
density and gravity have no part in it: the bin is the same for every soil.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import isotonic_regression

from synth.cache import cached
from synth.dem.contact_law import ContactLaw, damping_ratio_of
from synth.dem.grains import Grains
from synth.dem.packing import void_ratio
from synth.dem.settling import FIRST_SOLID_FRACTION, Bin
from synth.soil import GrainContact, Packing

Progress = Callable[[int, int], None]

RECIPE = 1
"""Raised when the way a sample is made changes: older ones in the cache are then left alone."""
FRICTIONS = (0.0, 0.05, 0.1, 0.2, 0.4, 0.7, 2.0)
"""Friction while settling at which samples are made; beyond the last nothing changes."""
SEEDS = (1, 2)
SIDE = 30
"""Width and depth of the standard bin / mean grain diameter."""
DIAMETER = 2e-3
"""Mean, of the grains in the standard bin, m."""
_BULK_DENSITY = 1700.0
"""kg/m3."""
_GRAVITY = 9.81
_STEPS_PER_CONTACT = 20


@dataclass(frozen=True)
class SettlingRelation:
    """Void ratio that grains settle at, by the friction between them meanwhile.

    Attributes
    ----------
    friction : tuple of float
        Ascending; the first is 0.
    void_ratio : tuple of float
        At these; never falling.
    """

    friction: tuple[float, ...]
    void_ratio: tuple[float, ...]

    @property
    def smallest(self) -> float:
        """Void ratio of the densest packing."""
        return self.void_ratio[0]

    @property
    def largest(self) -> float:
        """Void ratio of the loosest packing."""
        return self.void_ratio[-1]

    def relative_density(self, void_ratio: float) -> float:
        """0 at the loosest, 1 at the densest; beyond these where a packing is looser or denser than they."""
        return (self.largest - void_ratio) / (self.largest - self.smallest)

    def friction_for(self, relative_density: float) -> float:
        """Friction while settling that gives a relative density from 0 to 1."""
        wanted = self.largest - relative_density * (self.largest - self.smallest)
        return float(np.interp(wanted, self.void_ratio, self.friction))


def settling_relation(
    contact: GrainContact,
    polydispersity: float,
    *,
    packing: Packing | None = None,
    progress: Progress | None = None,
) -> SettlingRelation:
    """The relation of grains with such contacts: from `packing` if it is theirs, else measured and kept.

    `synth.devices.start_taichi` must have been called where `packing` is not theirs.

    Parameters
    ----------
    polydispersity : float
        Half-width of the uniform spread of diameters / mean.
    packing : Packing, optional
        What the soil's file says.
    """
    if packing is not None and packing.is_of(contact, polydispersity):
        return SettlingRelation(tuple(packing.friction), tuple(packing.void_ratio))
    means = []
    for part, friction in enumerate(FRICTIONS):
        means.append(np.mean([_void_ratio(contact, polydispersity, friction, seed) for seed in SEEDS]))
        if progress is not None:
            progress(part + 1, len(FRICTIONS))
    rising = isotonic_regression(np.array(means)).x  # what is left of chance between neighbours
    return SettlingRelation(FRICTIONS, tuple(float(value) for value in rising))


def _void_ratio(contact: GrainContact, polydispersity: float, friction: float, seed: int) -> float:
    made_from = {
        "recipe": RECIPE,
        "side": SIDE,
        "rolling_friction": contact.rolling_friction,
        "restitution": contact.restitution,
        "polydispersity": polydispersity,
        "friction": friction,
        "seed": seed,
    }

    def measure() -> float:
        return sample_void_ratio(settled_sample(contact, polydispersity, friction=friction, seed=seed))

    return float(cached("packing", made_from, measure))


def settled_sample(contact: GrainContact, polydispersity: float, *, friction: float, seed: int) -> Grains:
    """Discs settled with that friction in the standard bin."""
    standard = _standard_bin(polydispersity)
    density = _BULK_DENSITY / FIRST_SOLID_FRACTION
    dropped = standard.drop(np.random.default_rng([seed, 2]), density)
    law = replace(standard.soft_law(_unlimited_law(contact), _BULK_DENSITY), friction=friction)
    return standard.settle(dropped, law)


def sample_void_ratio(sample: Grains) -> float:
    """Void ratio of a sample in the standard bin, clear of its walls and surface."""
    return void_ratio(_standard_bin(0.0).solid_fraction(sample))


def _standard_bin(polydispersity: float) -> Bin:
    side = SIDE * DIAMETER
    return Bin(side, side, DIAMETER, polydispersity, _GRAVITY, _STEPS_PER_CONTACT)


def _unlimited_law(contact: GrainContact) -> ContactLaw:
    """Walls rub as silica does, whatever the soil's do: the measured packing is clear of them."""
    return ContactLaw(
        normal_stiffness=1e12,
        tangential_stiffness=0.5e12,
        damping_ratio=damping_ratio_of(contact.restitution),
        friction=contact.friction,
        wall_friction=0.5,
        implement_friction=0.0,
        rolling_friction=contact.rolling_friction,
    )
