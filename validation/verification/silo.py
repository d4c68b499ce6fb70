"""Janssen's law: in a silo, walls carry the weight, and the stress saturates with depth."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import curve_fit

from synth.dem.contact_law import ContactLaw
from synth.dem.solver import Solver
from synth.dem.tool import Tool
from synth.implements import Shape
from synth.scene import GRAVITY
from validation.verification.comparison import Comparison, Progress, compare, compare_with_bounds, part_of
from validation.verification.contact_forces import BACK, GLASS, LEFT, RIGHT, X, Y, Z, contact_forces
from validation.verification.discs import advance_for, law
from validation.verification.packing import DIAMETER, Box

_WALL_FRICTION = 0.3
_ROLLING_FRICTION = 0.3
"""Grains that roll freely would roll down the smooth walls, and mobilise half of the friction there."""
_SPEED = 0.01
"""Of the floor, which is lowered so that friction is mobilised at the walls, m/s."""
_FIRST_WAY, _SECOND_WAY = 1.0 * DIAMETER, 0.5 * DIAMETER
"""The floor is lowered by the first before, and by the second while stresses are averaged, m."""
_LOOKS = 30
_HEIGHTS = 40
_JANSSEN = (
    "Janssen, Z. Ver. Dtsch. Ing. 39 (1895) 1045: s = S (1 - exp(-q / S)), q = rho g depth, "
    "S = rho g section / sum over the walls of (length along the section x mu K)"
)


@dataclass(frozen=True)
class Silo:
    """A silo and what is in it.

    Attributes
    ----------
    kind : str
        What its rows are headed with.
    box : Box
    count : int
        Grains: a column that is several times as tall as stresses take to saturate.
    modulus : float
        Of contacts, Pa: more than a thousand times the stress at saturation.
    glass_friction : float
        Of the panes before and behind spheres.
    """

    kind: str
    box: Box
    count: int
    modulus: float
    glass_friction: float = 0.0

    @property
    def section(self) -> float:
        """Area across the height, m2; of discs, per metre of width."""
        return self.box.width * self.box.depth

    @property
    def walls(self) -> dict[str, "_WallPair"]:
        """Those that rub, by name."""
        pairs = {"wall": _WallPair(LEFT, RIGHT, X, self.box.depth)}
        if self.glass_friction:
            pairs["glass"] = _WallPair(GLASS, BACK, Y, self.box.width)
        return pairs


@dataclass(frozen=True)
class _WallPair:
    """Two walls opposite each other: their numbers, the axis they face along, and the length of each, m."""

    first: int
    second: int
    axis: int
    length: float


DISCS = Silo("discs", Box(20 * DIAMETER), 2400, 2e6)
"""Six widths tall."""
SLAB = Silo("slab", Box(10 * DIAMETER, thickness=5 * DIAMETER), 3400, 1e6)
"""Six widths tall; smooth glass carries nothing, so that stresses saturate as between two walls."""
ROUGH_SLAB = Silo("rough slab", Box(10 * DIAMETER, thickness=5 * DIAMETER), 1800, 1e6, _WALL_FRICTION)
"""Glass that rubs as the walls do saturates them three times as soon: half the height is enough."""


@dataclass(frozen=True)
class Stresses:
    """Means over the looks, Pa.

    Attributes
    ----------
    hydrostatic : ndarray
        Weight above / section: what the stress would be without walls, at some heights.
    vertical : ndarray
        From the forces between grains, at these.
    pressure, shear : dict of float
        Of walls that rub, over the middle half of the column.
    middle : ndarray of bool
        Heights of that half.
    base : float
        On the floor.
    bulk_weight : float
        Specific weight of the bed, N/m3.
    """

    hydrostatic: np.ndarray
    vertical: np.ndarray
    pressure: dict[str, float]
    shear: dict[str, float]
    middle: np.ndarray
    base: float
    bulk_weight: float


def janssen(progress: Progress) -> list[Comparison]:
    """Stress in a silo of discs whose floor is lowered slowly."""
    return compare_with_janssen(DISCS, measure_stresses(DISCS, progress))


def sphere_janssen(progress: Progress) -> list[Comparison]:
    """The same of spheres, between smooth panes of glass and between such that rub as the walls do."""
    silos = (SLAB, ROUGH_SLAB)
    rows = []
    for part, silo in enumerate(silos):
        rows += compare_with_janssen(silo, measure_stresses(silo, part_of(progress, part, len(silos))))
    return rows


def compare_with_janssen(silo: Silo, stresses: Stresses) -> list[Comparison]:
    """What was measured beside Janssen's law.

    One number is fitted, the stress S at which the profile saturates; it is then held against the one that
    follows, without a fit, from the stresses measured at the walls.
    """
    (saturation,), _ = curve_fit(_janssen_stress, stresses.hydrostatic, stresses.vertical, p0=[1000.0])
    misfit = stresses.vertical - _janssen_stress(stresses.hydrostatic, saturation)
    vertical = float(stresses.vertical[stresses.middle].mean())
    carried = sum(2 * pair.length * stresses.shear[name] for name, pair in silo.walls.items())
    unfitted = stresses.bulk_weight * silo.section * vertical / carried
    full = float(stresses.hydrostatic.max())
    rows = [
        *_friction_mobilised(stresses),
        *_pressure_ratios(stresses, vertical),
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
        _floor(silo, stresses, float(_janssen_stress(np.array(full), unfitted))),
        compare_with_bounds(
            "stress on the floor / hydrostatic",
            low=0.0,
            high=0.6,
            measured=stresses.base / full,
            source="saturation: a column of several times the height that it takes hangs on its walls",
        ),
    ]
    return [row.headed(silo.kind) for row in rows]


def _floor(silo: Silo, stresses: Stresses, expected: float) -> Comparison:
    """Stress on the floor beside the profile's end.

    Soil that goes down with the floor rubs the walls less, for about as far up as the narrowest way across
    (after Saint-Venant). Between panes that rub this is much of the depth that saturation takes.
    """
    quantity = "stress on the floor against the profile from K and mobilised friction, Pa"
    if not silo.glass_friction:
        return compare(quantity, reference=expected, measured=stresses.base, limit=0.15, source=_JANSSEN)
    return compare_with_bounds(
        quantity,
        low=expected,
        high=expected + stresses.bulk_weight * silo.box.depth,
        measured=stresses.base,
        source=f"{_JANSSEN}; and up to the weight of soil as high as the slab is thick",
    )


def _friction_mobilised(stresses: Stresses) -> list[Comparison]:
    return [
        compare(
            f"{name} friction mobilised",
            reference=_WALL_FRICTION,
            measured=shear / stresses.pressure[name],
            limit=0.1,
            source="Coulomb",
        )
        for name, shear in stresses.shear.items()
    ]


def _pressure_ratios(stresses: Stresses, vertical: float) -> list[Comparison]:
    return [
        compare_with_bounds(
            f"K = {name} pressure / mean vertical stress, not fitted",
            low=0.33,
            high=1.2,
            measured=pressure / vertical,
            source="from Rankine's active state of a soil of 30 degrees to a little above isotropic",
        )
        for name, pressure in stresses.pressure.items()
    ]


def _janssen_stress(hydrostatic: np.ndarray, saturation: float) -> np.ndarray:
    return saturation * (1 - np.exp(-hydrostatic / saturation))


def measure_stresses(silo: Silo, progress: Progress) -> Stresses:
    """Fill a silo, lower its floor, and average its stresses."""
    solver = _filled(silo, progress)
    assert solver.tool is not None
    solver.drive_tool(velocity_x=0.0, velocity_z=-_SPEED, spin=0.0, load=0.0)
    advance_for(solver, _FIRST_WAY / _SPEED)
    progress(7, 10)
    solver.take_tool_impulse()
    interval = _SECOND_WAY / _SPEED / _LOOKS
    start, looks = solver.time, []
    for look in range(_LOOKS):
        advance_for(solver, interval)
        looks.append(_look(silo, solver))
        progress(70 + 30 * look // _LOOKS, 100)
    base = -solver.take_tool_impulse().z / (solver.time - start) / silo.section
    return _mean(looks, silo, base)


def _filled(silo: Silo, progress: Progress) -> Solver:
    """Grains at rest on a floor that can be lowered."""
    box, thickness = silo.box, DIAMETER
    top_of_floor = 4 * DIAMETER
    ends = [(-2 * DIAMETER, 0.0), (box.width + 2 * DIAMETER, 0.0)]
    floor = Tool(Shape.chain(np.array(ends), thickness), x=0.0, z=top_of_floor - thickness)
    grains = box.lattice(silo.count, seed=11, bottom=top_of_floor)
    solver = box.solver(grains, _law(silo), tool=floor)
    looks = 20
    for look in range(looks):
        advance_for(solver, (box.time_to_fall(grains) + 0.05) / looks)
        progress(6 * look // looks, 10)
    return solver


def _law(silo: Silo) -> ContactLaw:
    return law(
        restitution=0.3,
        friction=0.5,
        wall_friction=_WALL_FRICTION,
        implement_friction=0.5,
        glass_friction=silo.glass_friction,
        rolling_friction=_ROLLING_FRICTION,
        stiffness=silo.box.stiffness(silo.modulus),
    )


@dataclass(frozen=True)
class _Look:
    """At one instant: stresses at heights, wall pressures and shears (Pa), specific weight (N/m3)."""

    vertical: np.ndarray
    hydrostatic: np.ndarray
    pressure: np.ndarray
    shear: np.ndarray
    bulk_weight: float


def _look(silo: Silo, solver: Solver) -> _Look:
    grains, forces = solver.read_grains(), contact_forces(solver)
    z, weight = grains.position[-1], grains.mass * GRAVITY
    bottom, top = z.min(), z.max()
    heights = np.linspace(bottom + 0.5 * DIAMETER, top - 2 * DIAMETER, _HEIGHTS)
    hydrostatic = np.array([weight[z > height].sum() for height in heights]) / silo.section
    low, high = np.quantile(z, [0.25, 0.75])
    inside = (z > low) & (z < high)
    pressure, shear = [], []
    for pair in silo.walls.values():
        first, second = (forces.from_walls[wall][:, inside].sum(axis=1) for wall in (pair.first, pair.second))
        area = 2 * pair.length * (high - low)
        pressure.append((first[pair.axis] - second[pair.axis]) / area)
        shear.append((first[Z] + second[Z]) / area)
    return _Look(
        forces.upward_through(heights, z) / silo.section,
        hydrostatic,
        np.array(pressure),
        np.array(shear),
        float(weight[inside].sum() / (high - low) / silo.section),
    )


def _mean(looks: Sequence[_Look], silo: Silo, base: float) -> Stresses:
    hydrostatic = np.mean([look.hydrostatic for look in looks], axis=0)
    pressure = np.mean([look.pressure for look in looks], axis=0)
    shear = np.mean([look.shear for look in looks], axis=0)
    return Stresses(
        hydrostatic,
        np.mean([look.vertical for look in looks], axis=0),
        dict(zip(silo.walls, pressure.tolist(), strict=True)),
        dict(zip(silo.walls, shear.tolist(), strict=True)),
        _middle(hydrostatic),
        base,
        float(np.mean([look.bulk_weight for look in looks])),
    )


def _middle(hydrostatic: np.ndarray) -> np.ndarray:
    """Heights with a quarter to three quarters of the weight above."""
    share = hydrostatic / hydrostatic.max()
    return (share > 0.25) & (share < 0.75)
