"""Discs dropped loosely into a bin, settled, and brought to rest: how beds and samples are made."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from synth.dem.contact_law import ContactLaw, largest_time_step
from synth.dem.grains import Grains
from synth.dem.packing import solid_fraction
from synth.dem.solver import Solver

Progress = Callable[[int, int], None]

FIRST_SOLID_FRACTION = 0.82
"""Guess of the share of area that settled discs fill, until it is measured."""
_STIFFNESS = 1000
"""Contact stiffness while settling / greatest pressure of the bed: soft is quick, hard packs right."""
_CALM = 2e-3
"""Settled: the speed that nine of ten grains stay below / that of a fall through a grain's own diameter."""
_LOOK = 2.5e-3
"""Time between two looks at how calm the bed is, s."""
_LONGEST_REST = 0.15
"""Time after which a bed is taken as it is, s: longer would only show that something else is wrong."""
_DRAG = 200.0
"""Rate at which motion dies away while the bed comes to rest, 1/s."""
_SKIN = 0.3
"""Of neighbour lists / mean grain diameter: grains that fall are soon somewhere else."""
MARGIN = 3
"""Grain diameters along walls and surface that are left out where the packing is measured."""
PITCH = 1.01
"""Distance of the places that grains are dropped from / diameter of the largest."""


@dataclass(frozen=True)
class Bin:
    """A bin that discs settle in.

    Attributes
    ----------
    width, depth : float
        Between the end walls, and of the bed that is wanted, m.
    grain_diameter : float
        Mean, m.
    polydispersity : float
        Half-width of the uniform spread / mean diameter.
    gravity : float
        m/s2, downwards.
    steps_per_contact : int
        Time steps in the shortest collision.
    """

    width: float
    depth: float
    grain_diameter: float
    polydispersity: float
    gravity: float
    steps_per_contact: int

    def drop(self, rng: np.random.Generator, density: float) -> Grains:
        """Grains of random size on a loose lattice, with small random velocities that break its order."""
        spread = self.polydispersity
        diameter = self.grain_diameter * rng.uniform(1 - spread, 1 + spread, self._count)
        pitch = self.grain_diameter * (1 + spread) * PITCH
        columns = int((self.width - 0.5 * pitch) / pitch)
        row, column = np.divmod(np.arange(diameter.size), columns)
        x = (column + 0.5 + 0.5 * (row % 2)) * pitch
        z = (row * np.sqrt(3) / 2 + 0.5) * pitch
        grains = Grains.at_rest(np.stack([x, z]), diameter / 2, density)
        return replace(grains, velocity=rng.normal(0, 0.05, grains.position.shape))

    @property
    def _count(self) -> int:
        """Grains for a little more than the depth of the bed, so that levelling has something to take off."""
        mean_square = self.grain_diameter**2 * (1 + self.polydispersity**2 / 3)
        area = self.width * (self.depth + 3 * self.grain_diameter)
        return int(FIRST_SOLID_FRACTION * area / (np.pi / 4 * mean_square))

    def settle(self, dropped: Grains, law: ContactLaw, progress: Progress | None = None) -> Grains:
        """Let grains fall together, come to rest, and take off what rises above the depth wanted."""
        fallen = self._fallen(dropped, law, _half(progress, 0))
        rested = self.rest(fallen, law, _half(progress, 1))
        return rested.only(rested.position[1] + rested.radius <= self.depth)

    def _fallen(self, grains: Grains, law: ContactLaw, progress: Progress | None) -> Grains:
        """Advance while the lattice collapses: a third longer than its top falls to the bed's depth."""
        height = float(grains.position[1].max()) - self.depth
        solver = self._solver(grains, law, drag=0.0)
        looks = max(1, round(1.33 * np.sqrt(2 * height / self.gravity) / _LOOK))
        for done in range(1, looks + 1):
            solver.advance(max(1, round(_LOOK / solver.time_step)))
            if progress is not None:
                progress(done, looks)
        return solver.read_grains()

    def rest(self, grains: Grains, law: ContactLaw, progress: Progress | None = None) -> Grains:
        """Advance against a drag until the grains are calm; they are then stopped altogether."""
        solver = self._solver(grains, law, drag=_DRAG)
        fall = np.sqrt(2 * self.gravity * self.grain_diameter)
        looks = round(_LONGEST_REST / _LOOK)
        now = grains
        for done in range(1, looks + 1):
            solver.advance(max(1, round(_LOOK / solver.time_step)))
            now = solver.read_grains()
            if progress is not None:
                progress(done, looks)
            if np.quantile(np.hypot(*now.velocity), 0.9) < _CALM * fall:
                break
        return Grains.at_rest(now.position, now.radius, now.density)

    def _solver(self, grains: Grains, law: ContactLaw, *, drag: float) -> Solver:
        step = largest_time_step(grains.mass, law.normal_stiffness, self.steps_per_contact)
        gravity = (0.0, -self.gravity)
        return Solver(grains, law, self.width, step, gravity=gravity, drag=drag, skin=_SKIN)

    def solid_fraction(self, grains: Grains) -> float:
        """Share of area filled by grains, clear of the walls and of the rough surface."""
        margin = MARGIN * self.grain_diameter
        return solid_fraction(
            grains, left=margin, right=self.width - margin, bottom=margin, top=self.depth - margin
        )

    def soft_law(self, law: ContactLaw, bulk_density: float) -> ContactLaw:
        """A law no stiffer than the weight of a bed of that density (kg/m3) needs."""
        enough = _STIFFNESS * bulk_density * self.gravity * self.depth
        share = min(1.0, enough / law.normal_stiffness)
        return replace(
            law,
            normal_stiffness=law.normal_stiffness * share,
            tangential_stiffness=law.tangential_stiffness * share,
        )


def _half(progress: Progress | None, part: int) -> Progress | None:
    """Progress of one of the two stages as progress of the whole."""
    if progress is None:
        return None
    return lambda done, total: progress(part * 100 + round(100 * done / total), 200)
