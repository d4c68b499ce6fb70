"""Angle of repose: the slope that remains when a bed has run off a ledge."""

from dataclasses import dataclass, replace

import numpy as np

from synth.dem.grains import Grains
from synth.dem.tool import Tool
from synth.implements import Shape
from validation.published import read_published
from validation.verification.comparison import Comparison, Progress, compare_with_bounds
from validation.verification.discs import advance_for, law
from validation.verification.packing import DIAMETER, FALLING_SKIN, Box, moved

_ROLLING_FRICTIONS = (0.0, 0.1, 0.3)
_SOURCE = "bound of this suite: discs in two dimensions, compare Lee and Herrmann, J. Phys. A 26 (1993) 373"
_BELOW_SLOW_FLOW = (
    "bound of this suite; above: the slope at which a deep flow of such spheres stops, the arc tangent of "
    "shear stress / pressure in slow shear: Chialvo, Sun, Sundaresan, Phys. Rev. E 85 (2012) 021305"
)
_SANDS = "bound of this suite: rounded to angular sands and gravels"
_ROLLING_RAISES = (
    "bound of this suite; rolling friction steepens heaps: Zhou et al., Physica A 269 (1999) 536"
)


@dataclass(frozen=True)
class Ledge:
    """A bed on a ledge, and the pit beside it.

    Attributes
    ----------
    bed : Box
        As long as the ledge.
    pit, drop : float
        Width of the pit, and from the ledge to its bottom, m.
    count : int
        Grains: the bed is higher than the steepest slope that is expected.
    modulus : float
        Of contacts, Pa: more than a thousand times the pressure below the bed.
    time : float
        Until the slope is measured, s.
    """

    bed: Box
    pit: float
    drop: float
    count: int
    modulus: float
    time: float


DISCS = Ledge(Box(45 * DIAMETER), 50 * DIAMETER, 30 * DIAMETER, 1200, 3e6, 0.8)
SLAB = Ledge(Box(26 * DIAMETER, thickness=4 * DIAMETER), 35 * DIAMETER, 20 * DIAMETER, 2400, 5e5, 0.5)


def repose(progress: Progress) -> list[Comparison]:
    """Slopes of discs of friction 0.5 that roll freely, and of such that resist rolling."""
    free, some, more = _angles(DISCS, progress)
    return [
        compare_with_bounds(
            "angle of repose, no rolling friction, degrees", low=10, high=24, measured=free, source=_SOURCE
        ),
        compare_with_bounds(
            "angle of repose, rolling friction 0.3, degrees", low=18, high=40, measured=more, source=_SOURCE
        ),
        *_rises(free, some, more),
    ]


def sphere_repose(progress: Progress) -> list[Comparison]:
    """The same of spheres between smooth panes of glass."""
    free, some, more = _angles(SLAB, progress)
    friction = read_published("critical_state")["sphere_friction"].value
    return [
        compare_with_bounds(
            "angle of repose, no rolling friction, degrees",
            low=10,
            high=float(np.degrees(np.arctan(friction))),
            measured=free,
            source=_BELOW_SLOW_FLOW,
        ),
        compare_with_bounds(
            "angle of repose, rolling friction 0.3, degrees", low=22, high=40, measured=more, source=_SANDS
        ),
        *_rises(free, some, more),
    ]


def _rises(free: float, some: float, more: float) -> list[Comparison]:
    return [
        compare_with_bounds(
            f"rise of the angle of repose, rolling friction {step}, degrees",
            low=0.5,
            high=15,
            measured=rise,
            source=_ROLLING_RAISES,
        )
        for step, rise in (("0 to 0.1", some - free), ("0.1 to 0.3", more - some))
    ]


def _angles(ledge: Ledge, progress: Progress) -> list[float]:
    angles = []
    for rolling_friction in _ROLLING_FRICTIONS:
        angles.append(angle_of_repose(ledge, rolling_friction))
        progress(len(angles), len(_ROLLING_FRICTIONS))
    return angles


def angle_of_repose(ledge: Ledge, rolling_friction: float, *, seed: int = 3) -> float:
    """Slope of what stays on the ledge, degrees."""
    return slope(ledge, run_off(ledge, rolling_friction, seed=seed))


def run_off(ledge: Ledge, rolling_friction: float, *, seed: int) -> Grains:
    """What a settled bed has become when it was free to run off its ledge."""
    rough = law(
        restitution=0.3,
        friction=0.5,
        wall_friction=0.5,
        implement_friction=1.0,
        rolling_friction=rolling_friction,
        stiffness=ledge.bed.stiffness(ledge.modulus),
    )
    bed = ledge.bed.settled(ledge.count, rough, seed=seed)
    room = replace(ledge.bed, width=ledge.bed.width + ledge.pit)
    solver = room.solver(moved(bed, z=ledge.drop), rough, tool=_shelf(ledge), skin=FALLING_SKIN)
    advance_for(solver, ledge.time)
    return solver.read_grains()


def _shelf(ledge: Ledge) -> Tool:
    """Its top is where the bed's floor was."""
    thickness = 1.5 * DIAMETER
    ends = np.array([(-4 * DIAMETER, 0.0), (ledge.bed.width, 0.0)])
    return Tool(Shape.chain(ends, thickness), x=0.0, z=ledge.drop - thickness)


def slope(ledge: Ledge, grains: Grains) -> float:
    """Slope of the line through the topmost grains, clear of the ledge's end and of the wall, degrees."""
    (x, z), pitch, length = grains.in_plane, 2 * DIAMETER, ledge.bed.width
    columns = np.arange(0.1 * length, 0.85 * length, pitch)
    tops = []
    for start in columns:
        inside = (x >= start) & (x < start + pitch) & (z > ledge.drop)
        tops.append(z[inside].max() if inside.any() else np.nan)
    known = np.isfinite(tops)
    slope = np.polyfit(columns[known], np.array(tops)[known], 1)[0]
    return float(np.degrees(np.arctan(-slope)))
