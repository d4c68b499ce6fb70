"""Biaxial compression between smooth platens: the friction angle at the critical state."""

from dataclasses import dataclass

import numpy as np

from synth.dem.contact_law import ContactLaw
from synth.dem.grains import Grains
from synth.dem.packing import solid_fraction, void_ratio
from synth.dem.solver import Solver
from synth.dem.tool import Tool
from synth.implements import Shape
from validation.published import read_published
from validation.verification.comparison import Comparison, Progress, compare, compare_with_bounds
from validation.verification.discs import DEFAULT, MASS, advance_for, law, solver_of
from validation.verification.packing import DIAMETER, settled

_COUNT = 900
_WIDTH = 30 * DIAMETER
PRESSURE = 1000.0
"""Confining pressure, Pa."""
STIFFNESS = 1000 * PRESSURE
"""Of contacts, N/m per metre of width."""
_RATE = 0.4
"""Rate of compression, 1/s: an inertial number of about 1e-3."""
_CRITICAL, _END = 0.15, 0.30
"""Strain from which on, and to which, stresses are averaged."""
STRAIN_STEP = 0.0025
"""Strain between two readings of the stresses."""
_HALF_THICKNESS = 2 * DIAMETER
_MARGIN = 3
"""Grain diameters along the platens that are left out where the packing is measured."""
_SEEDS = (5, 6)


def biaxial(progress: Progress) -> list[Comparison]:
    """Friction angle of discs of friction 0.5 that roll freely, and of such that resist rolling."""
    published = read_published("critical_state")["effective_friction"]
    runs = [(rolling_friction, seed) for rolling_friction in (0.0, 0.2) for seed in _SEEDS]
    found = {}
    for part, run in enumerate(runs):
        found[run] = critical_state(*run, _part(progress, part, len(runs)))
    free, resisting = (
        float(np.mean([found[rolling_friction, seed].sine for seed in _SEEDS]))
        for rolling_friction in (0.0, 0.2)
    )
    return [
        compare(
            "confining pressure kept, Pa",
            reference=PRESSURE,
            measured=float(np.mean([state.confining for state in found.values()])),
            limit=0.01,
            source="prescribed",
        ),
        compare(
            "sine of the critical-state friction angle, no rolling friction",
            reference=published.value,
            measured=free,
            limit=0.2,
            source="da Cruz et al., Phys. Rev. E 72 (2005) 021309: slow shear of discs of friction 0.4",
        ),
        compare_with_bounds(
            "that sine at rolling friction 0.2 / at none",
            low=1.1,
            high=2.0,
            measured=resisting / free,
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


def critical_state(rolling_friction: float, seed: int, progress: Progress) -> CriticalState:
    """Compress one sample and average its stresses at the critical state."""
    rough = law(restitution=0.3, friction=0.5, rolling_friction=rolling_friction, stiffness=STIFFNESS)
    poured = settled(_COUNT, _WIDTH, rough, seed=seed)
    test = compress(poured, rough, width=_WIDTH, end=_END, progress=progress)
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
        Before and after, clear of the platens.
    """

    stress: np.ndarray
    void_ratio: tuple[float, float]

    @property
    def sine(self) -> np.ndarray:
        """Of the friction angle mobilized over each step, shape (N,)."""
        across, confining = self.stress.T
        return (across - confining) / (across + confining)


def compress(
    poured: Grains, rough: ContactLaw, *, width: float, end: float, progress: Progress
) -> Compression:
    """Put settled grains between smooth platens under `PRESSURE`, and compress them.

    Parameters
    ----------
    poured : Grains
        At rest between the floor, z = 0, and walls at x = 0 and `width` (m).
    rough : ContactLaw
        Of stiffness `STIFFNESS`, its walls and implement without friction.
    end : float
        Strain to compress to.
    """
    cell = _filled_cell(poured, rough, width)
    before, looks = _void_ratio(cell), round(end / STRAIN_STEP)
    stress = []
    for look in range(1, looks + 1):
        stress.append(_compress(cell))
        progress(look, looks)
    return Compression(np.array(stress), (before, _void_ratio(cell)))


def _part(progress: Progress, part: int, parts: int) -> Progress:
    return lambda done, total: progress(part * total + done, parts * total)


def _compress(cell: Solver) -> tuple[float, float]:
    """Compress along x by one look's strain: mean stresses along x and z meanwhile, Pa."""
    width, height = _size(cell)
    cell.drive_tool(velocity_x=-_RATE * width, velocity_z=0.0, spin=0.0, load=PRESSURE * width)
    start = cell.time
    advance_for(cell, STRAIN_STEP / _RATE)
    given, time = cell.take_tool_impulse(), cell.time - start
    return given.x / time / height, given.z / time / width


def _size(cell: Solver) -> tuple[float, float]:
    """Width and height between the platens' inner faces, m."""
    corner = cell.read_tool()
    return corner.x - _HALF_THICKNESS, corner.z - _HALF_THICKNESS


def _void_ratio(cell: Solver) -> float:
    (width, height), margin = _size(cell), _MARGIN * DIAMETER
    return void_ratio(
        solid_fraction(
            cell.read_grains(), left=margin, right=width - margin, bottom=margin, top=height - margin
        )
    )


def _filled_cell(grains: Grains, rough: ContactLaw, width: float) -> Solver:
    """Grains settled under gravity, then without it between the platens.

    Roof and right wall are one angle: it is pushed along x as told and heaves under the confining load. Its
    upright leg reaches through the floor, which stops grains but no implements, so that no gap opens.
    """
    top = float((grains.position[1] + grains.radius).max())
    points = np.array([(-width - 8 * DIAMETER, 0.0), (0.0, 0.0), (0.0, -3 * top)])
    angle = Tool(
        Shape.chain(points, _HALF_THICKNESS),
        x=width + _HALF_THICKNESS,
        z=top + _HALF_THICKNESS,
        mass=30 * MASS,
        load=PRESSURE * width,
        heaves=True,
    )
    room = width + 4 * DIAMETER
    calming = solver_of(grains, rough, width=room, steps_per_contact=DEFAULT, drag=100.0, tool=angle)
    advance_for(calming, 0.05)
    return solver_of(
        calming.read_grains(), rough, width=room, steps_per_contact=DEFAULT, tool=calming.read_tool()
    )
