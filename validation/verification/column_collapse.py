"""Collapse of granular columns in two dimensions: run-out against aspect ratio."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from synth.dem.contact_law import ContactLaw
from synth.dem.grains import Grains
from synth.scene import GRAVITY
from validation.published import read_published
from validation.verification.comparison import Comparison, Progress, compare
from validation.verification.discs import DEFAULT, DENSITY, advance_for, law, solver_of
from validation.verification.packing import DIAMETER, settled

_LOW, _HIGH = (0.5, 1.0, 2.0), (3.0, 6.0, 12.0)
"""Height / half width of columns below and above the change of regime."""
_COUNT = 1500
_SOLID_FRACTION = 0.8
_DURATION = 3.5
"""Time until the heap is measured / free fall from the column's height."""
_TOUCH = 0.5 * DIAMETER
"""Gap across which grains still belong to the heap, m."""
_SOURCE = "Staron and Hinch, J. Fluid Mech. 545 (2005) 1; Lube et al., Phys. Rev. E 72 (2005) 041301"


def column_collapse(progress: Progress) -> list[Comparison]:
    """Run-out of columns between walls that vanish, to both sides, on a floor as rough as the grains."""
    published = read_published("column_collapse")
    ratios = (*_LOW, *_HIGH)
    runs = {}
    for done, ratio in enumerate(ratios):
        runs[ratio] = run_out(ratio)
        progress(done + 1, len(ratios))
    rows = []
    for name, chosen, nominal in (("low", _LOW, 1.0), ("high", _HIGH, 6.0)):
        exponent = published[f"exponent_{name}"].value
        factor = published[f"factor_{name}"].value
        rows.append(
            compare(
                f"exponent of run-out on aspect ratio, {chosen[0]} to {chosen[-1]}",
                reference=exponent,
                measured=float(np.polyfit(np.log(chosen), np.log([runs[ratio] for ratio in chosen]), 1)[0]),
                limit=0.15,
                source=_SOURCE,
            )
        )
        rows.append(
            compare(
                f"run-out / half width at aspect ratio {nominal}",
                reference=factor * nominal**exponent,
                measured=runs[nominal],
                limit=0.3,
                source=_SOURCE,
            )
        )
    return rows


def run_out(aspect_ratio: float, *, seed: int = 7) -> float:
    """(Final - initial half width) / initial half width, mean of both sides."""
    column = _column(aspect_ratio, seed)
    left, right = _extent(column, np.ones(column.count, bool))
    half_width, height = (right - left) / 2, float(np.ptp(column.position[1]))
    room = half_width * (1 + 6 * aspect_ratio)
    column = _moved(column, room - (left + right) / 2)
    fall = float(np.sqrt(2 * height / GRAVITY))
    solver = solver_of(
        column, _law(height), width=2 * room, gravity=(0.0, -GRAVITY), steps_per_contact=DEFAULT
    )
    advance_for(solver, _DURATION * fall)
    after = solver.read_grains()
    left, right = _extent(after, heap(after))
    return float((right - left) / 2 / half_width) - 1


def heap(grains: Grains) -> np.ndarray:
    """Mask of the grains that hang together with most of the others; those that rolled off alone do not."""
    reach = 2 * grains.radius.max() + _TOUCH
    i, j = cKDTree(grains.position.T).query_pairs(reach, output_type="ndarray").T
    gap = np.hypot(*(grains.position[:, i] - grains.position[:, j])) - grains.radius[i] - grains.radius[j]
    near = gap < _TOUCH
    graph = coo_array((np.ones(near.sum()), (i[near], j[near])), shape=(grains.count, grains.count))
    _, label = connected_components(graph, directed=False)
    return np.asarray(label == np.bincount(label).argmax())


def _column(aspect_ratio: float, seed: int) -> Grains:
    """A column at rest; a tall one is settled lying, which is quick, and then set up."""
    area = _COUNT * np.pi / 4 * DIAMETER**2 / _SOLID_FRACTION
    half_width = float(np.sqrt(area / (2 * aspect_ratio)))
    width, height = 2 * half_width, aspect_ratio * half_width
    bed = settled(_COUNT, max(width, height), _law(min(width, height)), seed=seed)
    if height <= width:
        return bed
    upright = bed.position[::-1] + np.array([[0.0], [float((bed.radius).max())]])
    return Grains.at_rest(upright, bed.radius, bed.density)


def _law(height: float) -> ContactLaw:
    """As rough as Staron's and Hinch's discs, two thousand times as stiff as the pressure below the column.

    Softer contacts allow time steps in which falling grains outrun the list of their neighbours.
    """
    pressure = DENSITY * _SOLID_FRACTION * GRAVITY * height
    return law(restitution=0.5, friction=1.0, wall_friction=1.0, stiffness=2000 * pressure)


def _extent(grains: Grains, chosen: np.ndarray) -> tuple[float, float]:
    """Leftmost and rightmost point of the chosen grains, m."""
    x, radius = grains.position[0][chosen], grains.radius[chosen]
    return float((x - radius).min()), float((x + radius).max())


def _moved(grains: Grains, by: float) -> Grains:
    """At rest, `by` further right (m)."""
    return Grains.at_rest(grains.position + np.array([[by], [0.0]]), grains.radius, grains.density)
