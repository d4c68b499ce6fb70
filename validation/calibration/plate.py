"""Pressure against sinkage of a plate that is pressed into a settled bed, and Bekker's law fitted to it."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from synth.cache import cached
from synth.dem.contact_law import ContactLaw, damping_ratio_of, largest_time_step
from synth.dem.grains import Grains
from synth.dem.relative_density import DIAMETER
from synth.dem.run import surface_height
from synth.dem.settling import FIRST_SOLID_FRACTION, Bin
from synth.dem.solver import Solver
from synth.dem.tool import Tool
from synth.implements import Shape
from synth.scene import GRAVITY
from synth.soil import Soil
from validation.verification.comparison import Progress
from validation.verification.discs import advance_for

RECIPE = 2
"""Raised when the test changes: older results in the cache are then left alone."""
WIDTH = 12 * DIAMETER
"""Of the plate, m."""
DEPTH = 16e-3
"""Sinkage that it is pressed to, m."""
_SPEED = 0.08
"""m/s: an inertial number of about 2e-3 under it."""
_BIN_WIDTH, _BIN_DEPTH = 90 * DIAMETER, 35 * DIAMETER
_STEPS_PER_CONTACT = 20
_STIFFNESS_HEIGHT = 1000.0
"""Contact stiffness / weight of soil a metre deep: a thousand times the pressure of a metre of soil."""
_LOOKS = 32
_FITTED_FROM = 0.1
"""Share of `DEPTH` from which on the law is fitted: the first grains that touch make no pressure yet."""
_HALF_THICKNESS = DIAMETER / 2
_HEIGHT = 2 * DEPTH
"""Of the punch: no grain comes over its top."""


@dataclass(frozen=True)
class PlateCurve:
    """Means over the seeds.

    Attributes
    ----------
    sinkage : tuple of float
        m.
    pressure : tuple of float
        Pa, at these.
    spread : tuple of float
        Standard deviation of the pressure from seed to seed, Pa.
    bulk_density : float
        Of the beds, measured after they came to rest, kg/m3.
    """

    sinkage: tuple[float, ...]
    pressure: tuple[float, ...]
    spread: tuple[float, ...]
    bulk_density: float

    def fit(self) -> "Bekker":
        """Least squares of log(pressure) on log(sinkage)."""
        sinkage, pressure = np.array(self.sinkage), np.array(self.pressure)
        fitted = (sinkage >= _FITTED_FROM * DEPTH) & (pressure > 0)
        exponent, log_modulus = np.polyfit(np.log(sinkage[fitted]), np.log(pressure[fitted]), 1)
        return Bekker(float(exponent), float(np.exp(log_modulus)))


@dataclass(frozen=True)
class Bekker:
    """Pressure = modulus x sinkage ** exponent, for a plate of `WIDTH`.

    Attributes
    ----------
    exponent : float
    modulus : float
        Pa / m**exponent: kc / WIDTH + kphi.
    """

    exponent: float
    modulus: float


def press_plate(
    soil: Soil,
    polydispersity: float,
    *,
    settling_friction: float,
    seeds: tuple[int, ...],
    progress: Progress,
) -> PlateCurve:
    """Press a plate into a bed for every seed; what is in the cache is not done again.

    Parameters
    ----------
    settling_friction : float
        That prepares the bed.
    """
    found = []
    for part, seed in enumerate(seeds):
        made_from = {
            "recipe": RECIPE,
            "contact": soil.contact.model_dump(mode="json"),
            "bulk_density": soil.bulk_density,
            "polydispersity": polydispersity,
            "settling_friction": settling_friction,
            "seed": seed,
        }
        part_done = partial(_tell, progress, part, len(seeds))
        press = partial(_press, soil, polydispersity, settling_friction, seed, part_done)
        found.append(cached("plate", made_from, press))
    pressures = np.array([one["pressure"] for one in found])
    spread = pressures.std(axis=0, ddof=1) if len(seeds) > 1 else np.zeros(_LOOKS)
    return PlateCurve(
        tuple(float(z) for z in _sinkages()),
        tuple(float(p) for p in pressures.mean(axis=0)),
        tuple(float(s) for s in spread),
        float(np.mean([one["bulk_density"] for one in found])),
    )


def _tell(progress: Progress, part: int, parts: int, done: int, total: int) -> None:
    progress(part * total + done, parts * total)


def _sinkages() -> np.ndarray:
    """Sinkage in the middle of each interval that the pressure is averaged over, m."""
    return (np.arange(_LOOKS) + 0.5) * DEPTH / _LOOKS


def _press(
    soil: Soil, polydispersity: float, settling_friction: float, seed: int, progress: Progress
) -> dict[str, object]:
    law = _law(soil)
    grains, bulk_density = _bed(soil, law, polydispersity, settling_friction, seed)
    tool, surface = _above(grains), surface_height(grains, DIAMETER)
    step = largest_time_step(grains.mass, law.normal_stiffness, _STEPS_PER_CONTACT)
    solver = Solver(grains, law, _BIN_WIDTH, step, gravity=(0.0, -GRAVITY), tool=tool)
    solver.drive_tool(velocity_x=0.0, velocity_z=-_SPEED, spin=0.0, load=0.0)
    advance_for(solver, (tool.z - _HALF_THICKNESS - surface) / _SPEED)
    solver.take_tool_impulse()  # of what stands out of the surface, from where sinkage counts
    pressure = []
    for look in range(1, _LOOKS + 1):
        start = solver.time
        advance_for(solver, DEPTH / _LOOKS / _SPEED)
        pressure.append(solver.take_tool_impulse().z / (solver.time - start) / WIDTH)
        progress(look, _LOOKS)
    return {"pressure": pressure, "bulk_density": bulk_density}


def _bed(
    soil: Soil, law: ContactLaw, polydispersity: float, settling_friction: float, seed: int
) -> tuple[Grains, float]:
    """A bed at rest, its grains as dense as its bulk wants it, and the bulk density measured then."""
    bed = Bin(_BIN_WIDTH, _BIN_DEPTH, DIAMETER, polydispersity, GRAVITY, _STEPS_PER_CONTACT)
    softer = replace(bed.soft_law(law, soil.bulk_density), friction=settling_friction)
    rng = np.random.default_rng([seed, 3])
    settled = bed.settle(bed.drop(rng, soil.bulk_density / FIRST_SOLID_FRACTION), softer)
    weighed = replace(settled, density=soil.bulk_density / bed.solid_fraction(settled))
    rested = bed.rest(weighed, law)
    return rested, rested.density * bed.solid_fraction(rested)


def _above(grains: Grains) -> Tool:
    """A punch with a flat bottom, clear of every grain beneath: those inside would be shot away."""
    half = WIDTH / 2 - _HALF_THICKNESS
    outline = np.array([(-half, _HEIGHT), (-half, 0.0), (half, 0.0), (half, _HEIGHT)])
    beneath = np.abs(grains.position[0] - _BIN_WIDTH / 2) < WIDTH / 2 + grains.radius
    highest = float((grains.position[1] + grains.radius)[beneath].max())
    bottom = max(highest, surface_height(grains, DIAMETER))
    return Tool(Shape.chain(outline, _HALF_THICKNESS), x=_BIN_WIDTH / 2, z=bottom + _HALF_THICKNESS)


def _law(soil: Soil) -> ContactLaw:
    contact = soil.contact
    stiffness = _STIFFNESS_HEIGHT * soil.bulk_density * GRAVITY
    return ContactLaw(
        normal_stiffness=stiffness,
        tangential_stiffness=0.5 * stiffness,
        damping_ratio=damping_ratio_of(contact.restitution),
        friction=contact.friction,
        wall_friction=contact.wall_friction,
        implement_friction=contact.implement_friction,
        rolling_friction=contact.rolling_friction,
    )
