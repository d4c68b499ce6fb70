"""Biaxial compression between smooth platens, of spheres between smooth glass: the critical state."""

from dataclasses import dataclass, replace

import numpy as np

from synth.dem.contact_law import ContactLaw
from synth.dem.grains import Grains
from synth.dem.solver import Solver
from synth.dem.tool import Tool
from synth.implements import Shape
from validation.published import read_published
from validation.verification.comparison import (
    Comparison,
    Progress,
    compare,
    compare_with_bounds,
    part_of,
)
from validation.verification.discs import MASS, advance_for, law
from validation.verification.packing import DIAMETER, Box

PRESSURE = 1000.0
"""Confining pressure, Pa."""
MODULUS = 1000 * PRESSURE
"""Of contacts, Pa: of discs, their stiffness, N/m per metre of width."""
_RATE = 0.4
"""Rate of compression, 1/s: an inertial number of about 1e-3."""
_CRITICAL, _END = 0.15, 0.30
"""Strain from which on, and to which, stresses are averaged."""
STRAIN_STEP = 0.0025
"""Strain between two readings of the stresses."""
_HALF_THICKNESS = 2 * DIAMETER
_MARGIN = 3
"""Grain diameters along the platens that are left out where the packing is measured."""
_FRICTION = 0.5
_ROLLING_FRICTION = 0.2
_SEEDS = (5, 6)


@dataclass(frozen=True)
class Sample:
    """What is compressed, and what is known of it.

    Attributes
    ----------
    box : Box
    count : int
        Grains.
    published : str
        The friction that was published for such grains, in `reference/critical_state.csv`.
    source : str
        Where.
    """

    box: Box
    count: int
    published: str
    source: str


DISCS = Sample(
    Box(30 * DIAMETER),
    900,
    "effective_friction",
    "da Cruz et al., Phys. Rev. E 72 (2005) 021309: slow shear of discs of friction 0.4",
)
SLAB = Sample(
    Box(16 * DIAMETER, thickness=5 * DIAMETER),
    1400,
    "sphere_friction",
    "Chialvo, Sun, Sundaresan, Phys. Rev. E 85 (2012) 021305: slow shear of spheres of friction 0.5",
)


def biaxial(progress: Progress) -> list[Comparison]:
    """Friction angle of discs of friction 0.5 that roll freely, and of such that resist rolling."""
    return _compared(DISCS, progress)


def sphere_biaxial(progress: Progress) -> list[Comparison]:
    """The same of spheres in plane strain."""
    return _compared(SLAB, progress)


def _compared(sample: Sample, progress: Progress) -> list[Comparison]:
    runs = [(rolling_friction, seed) for rolling_friction in (0.0, _ROLLING_FRICTION) for seed in _SEEDS]
    found = []
    for part, run in enumerate(runs):
        found.append(critical_state(sample, *run, part_of(progress, part, len(runs))))
    return compare_critical_states(sample, found[: len(_SEEDS)], found[len(_SEEDS) :])


def compare_critical_states(
    sample: Sample, free: list["CriticalState"], resisting: list["CriticalState"]
) -> list[Comparison]:
    """Critical states, one a seed, of grains that roll freely and of such that resist rolling."""
    sine, raised = (float(np.mean([state.sine for state in states])) for states in (free, resisting))
    return [
        compare(
            "confining pressure kept, Pa",
            reference=PRESSURE,
            measured=float(np.mean([state.confining for state in (*free, *resisting)])),
            limit=0.01,
            source="prescribed",
        ),
        compare(
            "sine of the critical-state friction angle, no rolling friction",
            reference=read_published("critical_state")[sample.published].value,
            measured=sine,
            limit=0.2,
            source=sample.source,
        ),
        compare_with_bounds(
            f"that sine at rolling friction {_ROLLING_FRICTION} / at none",
            low=1.1,
            high=2.0,
            measured=raised / sine,
            source="bound of this suite, compare Estrada et al., Phys. Rev. E 78 (2008) 021301",
        ),
    ]


@dataclass(frozen=True)
class CriticalState:
    """Mean stresses between strains of 0.15 and 0.3, Pa: along the compression, and confining."""

    across: float
    confining: float

    @property
    def sine(self) -> float:
        """Of the friction angle."""
        return (self.across - self.confining) / (self.across + self.confining)


def critical_state(sample: Sample, rolling_friction: float, seed: int, progress: Progress) -> CriticalState:
    """Compress one sample and average its stresses at the critical state."""
    stiffness = sample.box.stiffness(MODULUS)
    rough = law(restitution=0.3, friction=_FRICTION, rolling_friction=rolling_friction, stiffness=stiffness)
    poured = sample.box.settled(sample.count, rough, seed=seed)
    test = compress(poured, rough, box=sample.box, end=_END, progress=progress)
    across, confining = test.stress[round(_CRITICAL / STRAIN_STEP) :].mean(axis=0)
    return CriticalState(float(across), float(confining))


@dataclass(frozen=True)
class Compression:
    """A sample compressed along x under a constant pressure along z.

    Attributes
    ----------
    stress : ndarray, shape (N, 2)
        Mean stresses over each `STRAIN_STEP`, along x and along z, Pa.
    void_ratio : tuple of float
        Before and after, clear of the platens; of spheres, with what glass makes looser.
    """

    stress: np.ndarray
    void_ratio: tuple[float, float]

    @property
    def sine(self) -> np.ndarray:
        """Of the friction angle mobilized over each step, shape (N,)."""
        across, confining = self.stress.T
        return (across - confining) / (across + confining)


def compress(poured: Grains, rough: ContactLaw, *, box: Box, end: float, progress: Progress) -> Compression:
    """Put settled grains between smooth platens under `PRESSURE`, and compress them.

    Parameters
    ----------
    poured : Grains
        At rest in the box.
    rough : ContactLaw
        Of contacts of `MODULUS`; walls, implement and glass without friction.
    end : float
        Strain to compress to.
    """
    cell = _filled_cell(poured, rough, box)
    before, looks = _void_ratio(cell, box), round(end / STRAIN_STEP)
    stress = []
    for look in range(1, looks + 1):
        stress.append(_compress(cell, box.depth))
        progress(look, looks)
    return Compression(np.array(stress), (before, _void_ratio(cell, box)))


def _compress(cell: Solver, depth: float) -> tuple[float, float]:
    """Compress along x by one look's strain: mean stresses along x and z meanwhile, Pa."""
    width, height = _size(cell)
    load = PRESSURE * width * depth
    cell.drive_tool(velocity_x=-_RATE * width, velocity_z=0.0, spin=0.0, load=load)
    start = cell.time
    advance_for(cell, STRAIN_STEP / _RATE)
    given, time = cell.take_tool_impulse(), cell.time - start
    return given.x / time / height / depth, given.z / time / width / depth


def _size(cell: Solver) -> tuple[float, float]:
    """Width and height between the platens' inner faces, m."""
    corner = cell.read_tool()
    return corner.x - _HALF_THICKNESS, corner.z - _HALF_THICKNESS


def _void_ratio(cell: Solver, box: Box) -> float:
    (width, height), margin = _size(cell), _MARGIN * DIAMETER
    return box.void_ratio(
        cell.read_grains(), left=margin, right=width - margin, bottom=margin, top=height - margin
    )


def _filled_cell(grains: Grains, rough: ContactLaw, box: Box) -> Solver:
    """Grains settled under gravity, then without it between the platens.

    Roof and right wall are one angle: it is pushed along x as told and heaves under the confining load. Its
    upright leg reaches through the floor, which stops grains but no implements, so that no gap opens.
    """
    width, top = box.width, float((grains.position[-1] + grains.radius).max())
    points = np.array([(-width - 8 * DIAMETER, 0.0), (0.0, 0.0), (0.0, -3 * top)])
    angle = Tool(
        Shape.chain(points, _HALF_THICKNESS),
        x=width + _HALF_THICKNESS,
        z=top + _HALF_THICKNESS,
        mass=30 * MASS * box.depth,
        load=PRESSURE * width * box.depth,
        heaves=True,
    )
    room = replace(box, width=width + 4 * DIAMETER)
    calming = room.solver(grains, rough, gravity=0.0, drag=100.0, tool=angle)
    advance_for(calming, 0.05)
    return room.solver(calming.read_grains(), rough, gravity=0.0, tool=calming.read_tool())
