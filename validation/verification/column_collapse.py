"""Collapse of granular columns in a plane: run-out against aspect ratio."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from synth.dem.contact_law import ContactLaw
from synth.dem.grains import Grains, length_of
from synth.scene import GRAVITY
from validation.published import read_published
from validation.verification.comparison import Comparison, Progress, compare
from validation.verification.discs import DENSITY, advance_for, law
from validation.verification.packing import DIAMETER, FALLING_SKIN, Box, moved

_DURATION = 3.5
"""Time until the heap is measured / free fall from the column's height."""
_TOUCH = 0.5 * DIAMETER
"""Gap across which grains still belong to the heap, m."""


@dataclass(frozen=True)
class Collapse:
    """Columns of one kind of grains, and what was published of such.

    Attributes
    ----------
    thickness : float or None
        Of a slab of spheres between smooth panes of glass, m.
    count : int
        Grains that are poured for a column.
    low, high : tuple of float
        Height / half width of columns below and above the change of regime.
    friction, rolling_friction : float
        Of grains, floor and each other; friction on the floor is the same.
    published : str
        Table in `reference`.
    source : str
    """

    thickness: float | None
    count: int
    low: tuple[float, ...]
    high: tuple[float, ...]
    friction: float
    rolling_friction: float
    published: str
    source: str

    def box(self, width: float) -> Box:
        """Room for the grains, of a width in m."""
        return Box(width, self.thickness)

    def half_width(self, aspect_ratio: float) -> float:
        """Of a column that all grains fill, m."""
        return float(np.sqrt(self.box(1.0).area_of(self.count) / (2 * aspect_ratio)))

    def law(self, height: float) -> ContactLaw:
        """Two thousand times as stiff as the pressure below a column of a height in m.

        Softer contacts allow time steps in which falling grains outrun the list of their neighbours.
        """
        box = self.box(1.0)
        pressure = DENSITY * box.solid_fraction * GRAVITY * height
        return law(
            restitution=0.5,
            friction=self.friction,
            wall_friction=self.friction,
            rolling_friction=self.rolling_friction,
            stiffness=box.stiffness(2000 * pressure),
        )


DISCS = Collapse(
    thickness=None,
    count=1500,
    low=(0.5, 1.0, 2.0),
    high=(3.0, 6.0, 12.0),
    friction=1.0,
    rolling_friction=0.0,
    published="column_collapse",
    source="Staron and Hinch, J. Fluid Mech. 545 (2005) 1; Lube et al., Phys. Rev. E 72 (2005) 041301",
)
"""As rough as Staron's and Hinch's."""
SLAB = Collapse(
    thickness=4 * DIAMETER,
    count=1800,
    low=(0.5, 1.0, 1.8),
    high=(3.0, 6.0, 10.0),
    friction=0.5,
    rolling_friction=0.2,
    published="channel_collapse",
    source="Lube, Huppert, Sparks, Freundt, Phys. Rev. E 72 (2005) 041301: sand and more in a channel",
)
"""Rolling friction stands for the shape of sand."""


def column_collapse(progress: Progress) -> list[Comparison]:
    """Run-out of columns between walls that vanish, to both sides, on a floor as rough as the grains."""
    return _compared(DISCS, progress)


def sphere_column_collapse(progress: Progress) -> list[Comparison]:
    """The same of spheres in a channel between smooth panes of glass."""
    return _compared(SLAB, progress)


def _compared(collapse: Collapse, progress: Progress) -> list[Comparison]:
    ratios = (*collapse.low, *collapse.high)
    runs = {}
    for done, ratio in enumerate(ratios):
        runs[ratio] = run_out(collapse, ratio)
        progress(done + 1, len(ratios))
    return compare_run_outs(collapse, runs)


def compare_run_outs(collapse: Collapse, runs: dict[float, float]) -> list[Comparison]:
    """Exponents and one run-out in either regime, of run-outs by aspect ratio."""
    published = read_published(collapse.published)
    rows = []
    for name, chosen, nominal in (("low", collapse.low, 1.0), ("high", collapse.high, 6.0)):
        exponent = published[f"exponent_{name}"].value
        factor = published[f"factor_{name}"].value
        rows.append(
            compare(
                f"exponent of run-out on aspect ratio, {chosen[0]} to {chosen[-1]}",
                reference=exponent,
                measured=float(np.polyfit(np.log(chosen), np.log([runs[ratio] for ratio in chosen]), 1)[0]),
                limit=0.15,
                source=collapse.source,
            )
        )
        rows.append(
            compare(
                f"run-out / half width at aspect ratio {nominal}",
                reference=factor * nominal**exponent,
                measured=runs[nominal],
                limit=0.3,
                source=collapse.source,
            )
        )
    return rows


def run_out(collapse: Collapse, aspect_ratio: float, *, seed: int = 7) -> float:
    """(Final - initial half width) / initial half width, mean of both sides."""
    column = _column(collapse, aspect_ratio, seed)
    left, right = _extent(column, np.ones(column.count, bool))
    half_width, height = (right - left) / 2, float(np.ptp(column.position[-1]))
    room = half_width * (1 + 6 * aspect_ratio)
    column = moved(column, x=room - (left + right) / 2)
    fall = float(np.sqrt(2 * height / GRAVITY))
    solver = collapse.box(2 * room).solver(column, collapse.law(height), skin=FALLING_SKIN)
    advance_for(solver, _DURATION * fall)
    after = solver.read_grains()
    left, right = _extent(after, heap(after))
    return float((right - left) / 2 / half_width) - 1


def heap(grains: Grains) -> np.ndarray:
    """Mask of the grains that hang together with most of the others; those that rolled off alone do not."""
    reach = 2 * grains.radius.max() + _TOUCH
    i, j = cKDTree(grains.position.T).query_pairs(reach, output_type="ndarray").T
    distance = length_of(grains.position[:, i] - grains.position[:, j])
    near = distance - grains.radius[i] - grains.radius[j] < _TOUCH
    graph = coo_array((np.ones(near.sum()), (i[near], j[near])), shape=(grains.count, grains.count))
    _, label = connected_components(graph, directed=False)
    return np.asarray(label == np.bincount(label).argmax())


def _column(collapse: Collapse, aspect_ratio: float, seed: int) -> Grains:
    """A column at rest; a tall one is settled lying, which is quick, and then set up.

    Grains that stand out of it are taken off, so that it has the ratio asked for, however dense they are.
    """
    half_width = collapse.half_width(aspect_ratio)
    width, height = 2 * half_width, aspect_ratio * half_width
    box, depth = collapse.box(max(width, height)), min(width, height)
    bed = box.settled(collapse.count, collapse.law(depth), seed=seed)
    bed = bed.only(bed.position[-1] + bed.radius <= depth)
    if height <= width:
        return bed
    upright = replace(bed, position=bed.position[::-1])
    return moved(upright, z=float(bed.radius.max()))


def _extent(grains: Grains, chosen: np.ndarray) -> tuple[float, float]:
    """Leftmost and rightmost point of the chosen grains, m."""
    x, radius = grains.position[0][chosen], grains.radius[chosen]
    return float((x - radius).min()), float((x + radius).max())
