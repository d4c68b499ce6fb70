"""Janssen's law: in a silo, walls carry the weight, and the stress saturates with depth."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import curve_fit

from synth.dem.contact_law import ContactLaw
from synth.dem.solver import Solver
from synth.dem.tool import Tool
from synth.implements import Shape
from synth.scene import GRAVITY
from validation.verification.comparison import Comparison, Progress, compare, compare_with_bounds
from validation.verification.contact_forces import LEFT, RIGHT, contact_forces
from validation.verification.discs import DEFAULT, advance_for, law, solver_of
from validation.verification.packing import DIAMETER, loose_lattice, time_to_fall

_WIDTH = 20 * DIAMETER
_COUNT = 2400
"""Grains: a column about six times as tall as it is wide."""
_WALL_FRICTION = 0.3
_ROLLING_FRICTION = 0.3
"""Discs that roll freely would roll down the smooth walls, and mobilise half of the friction there."""
_STIFFNESS = 2e6
"""N/m per metre: more than a thousand times the stress at which it saturates."""
_SPEED = 0.01
"""Of the floor, which is lowered so that friction is mobilised at the walls, m/s."""
_FIRST_WAY, _SECOND_WAY = 1.0 * DIAMETER, 0.5 * DIAMETER
"""The floor is lowered by the first before, and by the second while stresses are averaged, m."""
_LOOKS = 30
_HEIGHTS = 40
_JANSSEN = (
    "Janssen, Z. Ver. Dtsch. Ing. 39 (1895) 1045, in two dimensions: s = S (1 - exp(-q / S)), "
    "S = rho g W / (2 mu K), q = rho g depth"
)


@dataclass(frozen=True)
class _Stresses:
    """Means over the looks, Pa, at some heights.

    Attributes
    ----------
    hydrostatic : ndarray
        Weight above / width: what the stress would be without walls.
    vertical : ndarray
        From the forces between grains.
    wall_pressure, wall_shear : float
        Of both walls over the middle half of the column.
    middle : ndarray of bool
        Heights of that half.
    base : float
        On the floor.
    bulk_weight : float
        Specific weight of the bed, N/m3.
    """

    hydrostatic: np.ndarray
    vertical: np.ndarray
    wall_pressure: float
    wall_shear: float
    middle: np.ndarray
    base: float
    bulk_weight: float


def janssen(progress: Progress) -> list[Comparison]:
    """Stress in a silo whose floor is lowered slowly.

    One number is fitted, the stress S at which Janssen's profile saturates; it is then held against the one
    that follows, without a fit, from the stresses measured at the walls.
    """
    stresses = _measured_stresses(progress)
    (saturation,), _ = curve_fit(_janssen_stress, stresses.hydrostatic, stresses.vertical, p0=[1000.0])
    misfit = stresses.vertical - _janssen_stress(stresses.hydrostatic, saturation)
    mobilised = stresses.wall_shear / stresses.wall_pressure
    ratio = stresses.wall_pressure / float(stresses.vertical[stresses.middle].mean())
    unfitted = stresses.bulk_weight * _WIDTH / (2 * mobilised * ratio)
    full = float(stresses.hydrostatic.max())
    return [
        compare(
            "wall friction mobilised",
            reference=_WALL_FRICTION,
            measured=mobilised,
            limit=0.1,
            source="Coulomb",
        ),
        compare_with_bounds(
            "K = wall pressure / mean vertical stress, not fitted",
            low=0.33,
            high=1.2,
            measured=ratio,
            source="from Rankine's active state of a soil of 30 degrees to a little above isotropic",
        ),
        compare(
            "stress at saturation S, fitted, against the one from K and mobilised friction, Pa",
            reference=unfitted,
            measured=float(saturation),
            limit=0.15,
            source=_JANSSEN,
        ),
        compare(
            "misfit of the profile with that S, root of mean square, Pa",
            reference=0.0,
            measured=float(np.sqrt((misfit**2).mean())),
            scale=float(saturation),
            limit=0.08,
            source=_JANSSEN,
        ),
        compare(
            "stress on the floor against the profile from K and mobilised friction, Pa",
            reference=float(_janssen_stress(np.array(full), unfitted)),
            measured=stresses.base,
            limit=0.15,
            source=_JANSSEN,
        ),
        compare_with_bounds(
            "stress on the floor / hydrostatic",
            low=0.0,
            high=0.6,
            measured=stresses.base / full,
            source="saturation: a column six widths tall must hang on its walls",
        ),
    ]


def _janssen_stress(hydrostatic: np.ndarray, saturation: float) -> np.ndarray:
    return saturation * (1 - np.exp(-hydrostatic / saturation))


def _measured_stresses(progress: Progress) -> _Stresses:
    solver = _filled_silo(progress)
    assert solver.tool is not None
    solver.drive_tool(velocity_x=0.0, velocity_z=-_SPEED, spin=0.0, load=0.0)
    advance_for(solver, _FIRST_WAY / _SPEED)
    progress(7, 10)
    solver.take_tool_impulse()
    interval = _SECOND_WAY / _SPEED / _LOOKS
    start, looks = solver.time, []
    for look in range(_LOOKS):
        advance_for(solver, interval)
        looks.append(_look(solver))
        progress(70 + 30 * look // _LOOKS, 100)
    base = -solver.take_tool_impulse().z / (solver.time - start) / _WIDTH
    vertical, pressure, shear, hydrostatic, bulk = (
        np.mean(part, axis=0) for part in zip(*looks, strict=True)
    )
    middle = _middle(hydrostatic)
    return _Stresses(hydrostatic, vertical, float(pressure), float(shear), middle, base, float(bulk))


def _filled_silo(progress: Progress) -> Solver:
    """Grains at rest on a floor that can be lowered."""
    thickness = DIAMETER
    top_of_floor = 4 * DIAMETER
    ends = [(-2 * DIAMETER, 0.0), (_WIDTH + 2 * DIAMETER, 0.0)]
    floor = Tool(Shape.chain(np.array(ends), thickness), x=0.0, z=top_of_floor - thickness)
    grains = loose_lattice(_COUNT, _WIDTH, seed=11, bottom=top_of_floor)
    solver = solver_of(
        grains, _law(), width=_WIDTH, gravity=(0.0, -GRAVITY), steps_per_contact=DEFAULT, tool=floor
    )
    looks = 20
    for look in range(looks):
        advance_for(solver, (time_to_fall(grains) + 0.05) / looks)
        progress(6 * look // looks, 10)
    return solver


def _law() -> ContactLaw:
    return law(
        restitution=0.3,
        friction=0.5,
        wall_friction=_WALL_FRICTION,
        implement_friction=0.5,
        rolling_friction=_ROLLING_FRICTION,
        stiffness=_STIFFNESS,
    )


def _look(solver: Solver) -> tuple[np.ndarray, float, float, np.ndarray, float]:
    """Vertical stress at heights, wall pressure and shear, hydrostatic stress at heights, specific weight."""
    grains, forces = solver.read_grains(), contact_forces(solver)
    z, weight = grains.position[1], grains.mass * GRAVITY
    bottom, top = z.min(), z.max()
    heights = np.linspace(bottom + 0.5 * DIAMETER, top - 2 * DIAMETER, _HEIGHTS)
    vertical = forces.upward_through(heights, z) / _WIDTH
    hydrostatic = np.array([weight[z > height].sum() for height in heights]) / _WIDTH
    low, high = np.quantile(z, [0.25, 0.75])
    inside = (z > low) & (z < high)
    area = 2 * (high - low)
    pressure = (forces.from_walls[LEFT, 0] - forces.from_walls[RIGHT, 0])[inside].sum() / area
    shear = (forces.from_walls[LEFT, 1] + forces.from_walls[RIGHT, 1])[inside].sum() / area
    bulk = weight[inside].sum() / (high - low) / _WIDTH
    return vertical, float(pressure), float(shear), hydrostatic, float(bulk)


def _middle(hydrostatic: np.ndarray) -> np.ndarray:
    """Heights with a quarter to three quarters of the weight above."""
    share = hydrostatic / hydrostatic.max()
    return (share > 0.25) & (share < 0.75)
