"""Cohesion: two grains against a known pull, and a column that stands."""

from dataclasses import dataclass, replace

import numpy as np

from synth.dem.contact_law import ContactLaw
from synth.dem.grains import Spheres
from synth.dem.solver import Solver
from synth.scene import GRAVITY
from validation.verification.comparison import Comparison, compare, compare_with_bounds
from validation.verification.discs import (
    DENSITY,
    RADIUS,
    STIFFNESS,
    advance_for,
    discs_at,
    law,
    solver_of,
)
from validation.verification.packing import DIAMETER, Box, moved
from validation.verification.spheres import sphere_solver, spheres_at

_COHESION = 2.0
"""Force that parts two discs, N/m."""
_TURNS = 3
_SOURCE = "closed form: what a spinning pair pulls, m r omega^2, is held by stiffness x overlap - cohesion"


def held_pair() -> list[Comparison]:
    """Two grains turn about each other: below the pull of their cohesion they hold, above they part."""
    rows = []
    for kind in ("discs", "spheres"):
        for share in (0.5, 0.98):
            solver, expected = _spinning_pair(kind, share)
            start = solver.time
            while solver.time - start < _TURNS * expected.turn:
                solver.advance(64)
            overlap = _overlap(solver)
            rows.append(
                compare(
                    f"stiffness x overlap of two {kind} that pull {share} of their cohesion, / cohesion",
                    reference=1 - share,
                    measured=expected.stiffness * overlap / expected.cohesion,
                    scale=1.0,
                    limit=0.01,
                    source=_SOURCE,
                )
            )
        solver, expected = _spinning_pair(kind, 1.02)
        advance_for(solver, _TURNS * expected.turn)
        rows.append(
            compare_with_bounds(
                f"gap of two {kind} that pull 1.02 of their cohesion, after three turns, / radius",
                low=1.0,
                high=40.0,
                measured=-_overlap(solver) / RADIUS,
                source=_SOURCE,
            )
        )
    return rows


@dataclass(frozen=True)
class _Expected:
    """Force that parts the pair, stiffness of their contact, and the time of a turn."""

    cohesion: float
    stiffness: float
    turn: float


def _spinning_pair(kind: str, share: float) -> tuple[Solver, _Expected]:
    """Two smooth grains about their common centre, at the overlap that their pull leaves them."""
    discs = kind == "discs"
    stiffness = STIFFNESS if discs else 1000.0
    smooth = _sticky(law(restitution=0.5, stiffness=stiffness), _COHESION)
    cohesion = _COHESION if discs else _COHESION * RADIUS / 2
    x = np.array([0.5 - RADIUS, 0.5 + RADIUS])
    mass = float(discs_at([[0.5], [0.5]]).mass[0]) if discs else float(_spheres(x, 0.0).mass[0])
    overlap = (1 - share) * cohesion / stiffness
    arm = RADIUS - overlap / 2
    omega = float(np.sqrt(share * cohesion / (mass * arm)))
    x = np.array([0.5 - arm, 0.5 + arm])
    speed = omega * arm
    if discs:
        grains = discs_at(np.stack([x, [0.5, 0.5]]), velocity=np.array([[0, 0], [-speed, speed]]))
        solver = solver_of(grains, smooth, steps_per_contact=100)
    else:
        solver = sphere_solver(_spheres(x, speed), smooth, steps_per_contact=100)
    return solver, _Expected(cohesion, stiffness, 2 * np.pi / omega)


def _spheres(x: np.ndarray, speed: float) -> Spheres:
    return spheres_at(
        [x, [0.5, 0.5], [0.5, 0.5]], RADIUS, DENSITY, velocity=[[0, 0], [0, 0], [-speed, speed]]
    )


def _overlap(solver: Solver) -> float:
    place = solver.read_grains().position
    return 2 * RADIUS - float(np.linalg.norm(place[:, 1] - place[:, 0]))


def _sticky(dry: ContactLaw, cohesion: float) -> ContactLaw:
    return replace(dry, cohesion=cohesion)


def standing_column() -> list[Comparison]:
    """A column of 200 discs loses its walls: dry it falls apart, cohesive it stands."""
    dry = law(restitution=0.5, friction=0.5, wall_friction=0.5)
    bed = Box(8 * DIAMETER).settled(200, dry, seed=8)
    height = float(np.ptp(bed.position[1]))
    weight = float(bed.mass.sum()) * GRAVITY
    left = {}
    for cohesion in (0.0, 4 * weight / 8):
        solver = Box(0.4).solver(moved(bed, x=0.2), _sticky(dry, cohesion))
        advance_for(solver, 3 * float(np.sqrt(2 * height / GRAVITY)))
        left[cohesion] = float(np.ptp(solver.read_grains().position[1])) / height
    # Unconfined, grains of friction 0.5 carry a stress of about cohesion / diameter: four times the need.
    source = "bound of this suite"
    dry_height, sticky_height = left.values()
    return [
        compare_with_bounds(
            "height of a dry column after its collapse / before",
            low=0.05,
            high=0.7,
            measured=dry_height,
            source=source,
        ),
        compare_with_bounds(
            "height of a cohesive column / before", low=0.95, high=1.05, measured=sticky_height, source=source
        ),
    ]
