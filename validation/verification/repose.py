"""Angle of repose: the slope that remains when a bed has run off a ledge."""

import numpy as np

from synth.dem.grains import Grains
from synth.dem.tool import Tool
from synth.implements import Shape
from synth.scene import GRAVITY
from validation.verification.comparison import Comparison, Progress, compare_with_bounds
from validation.verification.discs import DEFAULT, advance_for, law, solver_of
from validation.verification.packing import DIAMETER, settled

_LENGTH, _PIT, _DROP = 45 * DIAMETER, 50 * DIAMETER, 30 * DIAMETER
"""Of the ledge, of the pit beside it, and from one to the other's bottom, m."""
_COUNT = 1200
_TIME = 0.8
"""Until the slope is measured, s."""
_SOURCE = "bound of this suite: discs in two dimensions, compare Lee and Herrmann, J. Phys. A 26 (1993) 373"
_ROLLING_RAISES = (
    "bound of this suite; rolling friction steepens heaps: Zhou et al., Physica A 269 (1999) 536"
)


def repose(progress: Progress) -> list[Comparison]:
    """Slopes of discs of friction 0.5 that roll freely, and of such that resist rolling."""
    angles = {}
    coefficients = (0.0, 0.1, 0.3)
    for done, rolling_friction in enumerate(coefficients):
        angles[rolling_friction] = angle_of_repose(rolling_friction)
        progress(done + 1, len(coefficients))
    free, some, more = (angles[coefficient] for coefficient in coefficients)
    return [
        compare_with_bounds(
            "angle of repose, no rolling friction, degrees", low=10, high=24, measured=free, source=_SOURCE
        ),
        compare_with_bounds(
            "angle of repose, rolling friction 0.3, degrees", low=18, high=40, measured=more, source=_SOURCE
        ),
        compare_with_bounds(
            "rise of the angle of repose, rolling friction 0 to 0.1, degrees",
            low=0.5,
            high=15,
            measured=some - free,
            source=_ROLLING_RAISES,
        ),
        compare_with_bounds(
            "rise of the angle of repose, rolling friction 0.1 to 0.3, degrees",
            low=0.5,
            high=15,
            measured=more - some,
            source=_ROLLING_RAISES,
        ),
    ]


def angle_of_repose(rolling_friction: float, *, seed: int = 3) -> float:
    """Slope of what stays on the ledge, degrees."""
    rough = law(
        restitution=0.3,
        friction=0.5,
        wall_friction=0.5,
        implement_friction=1.0,
        rolling_friction=rolling_friction,
        stiffness=3e6,
    )
    bed = settled(_COUNT, _LENGTH, rough, seed=seed)
    raised = Grains.at_rest(bed.position + np.array([[0.0], [_DROP]]), bed.radius, bed.density)
    solver = solver_of(
        raised,
        rough,
        width=_LENGTH + _PIT,
        gravity=(0.0, -GRAVITY),
        steps_per_contact=DEFAULT,
        tool=_ledge(),
    )
    advance_for(solver, _TIME)
    return _slope(solver.read_grains())


def _ledge() -> Tool:
    """A shelf whose top is where the bed's floor was."""
    thickness = 1.5 * DIAMETER
    ends = np.array([(-4 * DIAMETER, 0.0), (_LENGTH, 0.0)])
    return Tool(Shape.chain(ends, thickness), x=0.0, z=_DROP - thickness)


def _slope(grains: Grains) -> float:
    """Slope of the line through the topmost grains, clear of the ledge's end and of the wall, degrees."""
    (x, z), pitch = grains.position, 2 * DIAMETER
    columns = np.arange(0.1 * _LENGTH, 0.85 * _LENGTH, pitch)
    tops = []
    for start in columns:
        inside = (x >= start) & (x < start + pitch) & (z > _DROP)
        tops.append(z[inside].max() if inside.any() else np.nan)
    known = np.isfinite(tops)
    slope = np.polyfit(columns[known], np.array(tops)[known], 1)[0]
    return float(np.degrees(np.arctan(-slope)))
