"""The settled slab: spheres dropped loosely between glass and mirror, settled, levelled, weighed.

The stages are those of `synth.dem.bed`, in three dimensions.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from synth.dem.contact_law import ContactLaw, Law, damping_ratio_of, time_step_of
from synth.dem.grains import Grains, Spheres, length_of
from synth.dem.solver import Solver
from synth.scene import SoilBinScene

Progress = Callable[[int, int], None]

_FIRST_SOLID_FRACTION = 0.60
"""Guess of the share of volume that settled spheres fill, until it is measured."""
_SETTLING_STIFFNESS = 1000
"""Contact stiffness per diameter while settling / greatest pressure of the bed."""
_CALM = 2e-3
"""Settled: the speed that nine of ten grains stay below / that of a fall through a grain's own diameter."""
_LOOK = 5e-3
"""Time between two looks at how calm the bed is, s."""
_LONGEST_REST = 0.15
"""Time after which a bed is taken as it is, s."""
_DRAG = 200.0
"""Rate at which motion dies away while the bed comes to rest, 1/s."""


def prepare_slab(scene: SoilBinScene, law: Law, *, progress: Progress | None = None) -> tuple[Spheres, float]:
    """Drop, settle, level, weigh, and let come to rest.

    Settling has linear contacts, whatever the scene's are: only the packing counts there.

    Returns
    -------
    Spheres
        At rest, neighbours in the bin neighbours in memory.
    float
        Share of the bed's volume that they fill.
    """
    settling = _Stage(scene, _settling_law(scene, law), progress)
    dropped = _dropped(scene, np.random.default_rng([scene.seed, 1]))
    settled = settling.rest(settling.fall(dropped), part=1)
    levelled = settled.only(settled.position[2] + settled.radius <= scene.bed.depth)
    solid_fraction = _solid_fraction(levelled, scene)
    weighed = replace(levelled, density=scene.soil.bulk_density / solid_fraction)
    rested = _Stage(scene, law, progress).rest(weighed, part=2)
    return _spheres(rested.only(_by_column(rested))), solid_fraction


def _spheres(grains: Grains) -> Spheres:
    assert isinstance(grains, Spheres)
    return grains


def _settling_law(scene: SoilBinScene, law: Law) -> ContactLaw:
    """Soft linear contacts, with the friction that sets the density."""
    bed = scene.bed
    assert bed.settling_friction is not None
    pressure = scene.soil.bulk_density * bed.gravity * bed.depth
    stiffness = _SETTLING_STIFFNESS * pressure * bed.grain_diameter
    if isinstance(law, ContactLaw):
        stiffness = min(stiffness, law.normal_stiffness)
    return ContactLaw(
        normal_stiffness=stiffness,
        tangential_stiffness=stiffness * scene.contact.tangential_stiffness_ratio,
        damping_ratio=damping_ratio_of(law.restitution),
        friction=bed.settling_friction,
        wall_friction=law.wall_friction,
        implement_friction=law.implement_friction,
        rolling_friction=law.rolling_friction,
        glass_friction=law.glass_friction,
    )


def _dropped(scene: SoilBinScene, rng: np.random.Generator) -> Spheres:
    """Spheres of random size on a loose lattice, with small random velocities that break its order."""
    bed = scene.bed
    largest = bed.grain_diameter * (1 + bed.polydispersity)
    along, across = int(bed.width / (1.02 * largest)), int(bed.thickness / (1.02 * largest))
    cube = bed.grain_diameter**3 * (1 + bed.polydispersity**2)
    volume = bed.width * bed.thickness * (bed.depth + 3 * bed.grain_diameter)
    count = int(_FIRST_SOLID_FRACTION * volume / (np.pi / 6 * cube))
    layer, place = np.divmod(np.arange(count), along * across)
    row, column = np.divmod(place, along)
    radius = bed.grain_diameter / 2 * rng.uniform(1 - bed.polydispersity, 1 + bed.polydispersity, count)
    position = np.stack(
        [
            (column + 0.5) * bed.width / along,
            (row + 0.5) * bed.thickness / across,
            (layer + 0.5) * 1.02 * largest,
        ]
    )
    grains = Spheres.at_rest(position, radius, scene.soil.bulk_density / _FIRST_SOLID_FRACTION)
    return replace(grains, velocity=rng.normal(0, 0.05, position.shape))


@dataclass(frozen=True)
class _Stage:
    """Part of the settling, with its contact law."""

    scene: SoilBinScene
    law: Law
    progress: Progress | None

    def fall(self, grains: Spheres) -> Grains:
        """Advance while the lattice collapses: a third longer than its top falls to the bed's depth."""
        height = float(grains.position[2].max()) - self.scene.bed.depth
        solver = self._solver(grains, drag=0.0)
        looks = max(1, round(1.33 * np.sqrt(2 * height / self.scene.bed.gravity) / _LOOK))
        for done in range(1, looks + 1):
            solver.advance(max(1, round(_LOOK / solver.time_step)))
            self._tell(0, done, looks)
        return solver.read_grains()

    def rest(self, grains: Grains, *, part: int) -> Grains:
        """Advance against a drag until the grains are calm; they are then stopped altogether."""
        bed = self.scene.bed
        solver, now = self._solver(grains, drag=_DRAG), grains
        fall = np.sqrt(2 * bed.gravity * bed.grain_diameter)
        looks = round(_LONGEST_REST / _LOOK)
        for done in range(1, looks + 1):
            solver.advance(max(1, round(_LOOK / solver.time_step)))
            now = solver.read_grains()
            self._tell(part, done, looks)
            if np.quantile(length_of(now.velocity), 0.9) < _CALM * fall:
                break
        return Spheres.at_rest(now.position, now.radius, now.density)

    def _solver(self, grains: Grains, *, drag: float) -> Solver:
        bed = self.scene.bed
        step = time_step_of(grains, self.law, self.scene.contact.steps_per_contact)
        gravity = (0.0, -bed.gravity)
        return Solver(grains, self.law, bed.width, step, gravity=gravity, drag=drag, thickness=bed.thickness)

    def _tell(self, part: int, done: int, total: int) -> None:
        if self.progress is not None:
            self.progress(part * 100 + round(100 * done / total), 300)


def _solid_fraction(grains: Grains, scene: SoilBinScene) -> float:
    """Share of volume filled by spheres, clear of end walls, floor and surface; glass and mirror count."""
    (x, _, z), bed = grains.position, scene.bed
    margin = 3 * bed.grain_diameter
    inside = (x > margin) & (x < bed.width - margin) & (z > margin) & (z < bed.depth - margin)
    volume = (bed.width - 2 * margin) * (bed.depth - 2 * margin) * bed.thickness
    return float(grains.volume[inside].sum() / volume)


def _by_column(grains: Grains) -> np.ndarray:
    """Order of the grains cell by cell, so that neighbours in the bin are neighbours in memory."""
    cell = np.floor(grains.position / (2 * grains.radius.max())).astype(np.int64)
    return np.lexsort((cell[1], cell[2], cell[0]))
