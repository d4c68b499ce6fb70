"""Graded beds: fine grains where the camera sees and the implement works, coarser ones around.

A packing of discs with linear contacts knows no length but its grains': coarser ones weigh as much, are as
stiff and as strong per area, so that they can stand for the soil around the place where it is looked at.
"""

from dataclasses import dataclass, replace

import numpy as np

from synth.dem.grains import Grains
from synth.dem.packing import solid_fraction
from synth.dem.settling import FIRST_SOLID_FRACTION, MARGIN, PITCH, Bin
from synth.scene import FineRegion, SoilBinScene

_BEYOND = 5
"""Grain diameters that the finest grains reach beyond what is seen."""
_WORKED = 0.6
"""How far an implement works soil / its reach: along the bin to both sides, and below the surface."""
_LAYER = 6
"""Thickness of a layer between finest and coarsest grains / its own diameter."""
_NARROW = 3
"""Coarsest diameters: where less than that is left up to a wall, the finest grains reach the wall."""
_STATIONS = 101


def region_worked_and_seen(scene: SoilBinScene) -> FineRegion:
    """What the camera sees of the bed over all frames, as deep as the implement works, with a margin.

    Also the place of its touch-down, which the camera may not see any more. Deeper, soil hardly moves: what
    the camera sees there may be coarser.
    """
    bed, camera, program = scene.bed, scene.camera, scene.program
    frames = np.linspace(0, (scene.timing.frame_count - 1) / scene.timing.frame_rate, _STATIONS)
    axle = np.array([scene.drive.start + program.travel(time) for time in frames])
    centre = camera.centre_x + (axle if camera.follows == "carriage" else 0 * axle)
    seen = (1 + abs(scene.nuisance.distortion)) * camera.metres_per_pixel / 2
    least, greatest = program.reach_x(float(frames[-1]))
    worked = scene.drive.start + least, scene.drive.start + greatest
    reach, margin = scene.implement.shape.reach, _BEYOND * bed.grain_diameter
    left = min(centre.min() - camera.width * seen, worked[0] - _WORKED * reach) - margin
    right = max(centre.max() + camera.width * seen, worked[1] + _WORKED * reach) + margin
    bottom = bed.depth - _WORKED * reach - margin
    narrow = _NARROW * bed.coarsening * bed.grain_diameter
    return FineRegion(
        left=float(left) if left > narrow else 0.0,
        right=float(right) if right < bed.width - narrow else bed.width,
        bottom=float(bottom) if bottom > narrow else 0.0,
    )


@dataclass(frozen=True)
class GradedBin(Bin):
    """A bin whose discs are of `grain_diameter` in one region, and coarser layer by layer away from it.

    Attributes
    ----------
    coarsening : float
        Mean diameter of the coarsest / of the finest.
    left, right, fine_bottom : float
        The region of the finest, up to the surface, m. One that reaches a wall has nothing coarser there.
    """

    coarsening: float = 1.0
    left: float = 0.0
    right: float = np.inf
    fine_bottom: float = 0.0

    @property
    def diameters(self) -> np.ndarray:
        """Mean diameter of each layer, from the finest out, each at most twice the last, m."""
        count = int(np.ceil(np.log2(self.coarsening) - 1e-9))
        return self.grain_diameter * self.coarsening ** np.linspace(0, 1, count + 1)

    def distance(self, x: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Distance of dropped grains from what will be the region's border, m; negative inside."""
        far = np.full_like(x, np.inf)
        left = far if self.left <= 0 else x - self.left
        right = far if self.right >= self.width else self.right - x
        above = far if self.fine_bottom <= 0 else z - self.fine_bottom * self._fall
        inside = np.minimum(np.minimum(left, right), above)
        aside = np.maximum(-np.minimum(left, right), 0)
        return np.where(inside > 0, -inside, np.hypot(aside, np.maximum(-above, 0)))

    def drop(self, rng: np.random.Generator, density: float) -> Grains:
        """Grains of random size on loose lattices, one a layer, that fall to where that layer is wanted."""
        diameters = self.diameters
        ends = np.concatenate([[0.0], np.cumsum(_LAYER * diameters[1:-1]), [np.inf]])
        starts = np.concatenate([[-np.inf], ends[:-1]])
        parts = []
        for diameter, start, end in zip(diameters, starts, ends, strict=True):
            x, z = self._lattice(diameter)
            # Half a pitch from the border: so that layers keep clear of each other.
            clear, away = self._pitch(diameter) / 2, self.distance(x, z)
            kept = (away >= start + clear) & (away <= end - clear)
            size = diameter * rng.uniform(1 - self.polydispersity, 1 + self.polydispersity, kept.sum())
            parts.append((np.stack([x[kept], z[kept]]), size / 2))
        position = np.concatenate([part[0] for part in parts], axis=1)
        grains = Grains.at_rest(position, np.concatenate([part[1] for part in parts]), density)
        return replace(grains, velocity=rng.normal(0, 0.05, position.shape))

    def _pitch(self, diameter: float) -> float:
        return diameter * (1 + self.polydispersity) * PITCH

    @property
    def _fall(self) -> float:
        """Height of a place in the lattice / that which its grain falls to: the same for every diameter."""
        pitch = self._pitch(1.0)
        filled = np.pi / 4 * (1 + self.polydispersity**2 / 3) / (np.sqrt(3) / 2 * pitch**2)
        return float(FIRST_SOLID_FRACTION / filled)

    def _lattice(self, diameter: float) -> tuple[np.ndarray, np.ndarray]:
        """Places all over the bin, m."""
        pitch = self._pitch(diameter)
        # Something for levelling to take off, and for the gaps between layers.
        top = self.depth + 3 * diameter + self.diameters[1:].sum()
        rows = int(top * self._fall / (np.sqrt(3) / 2 * pitch))
        columns = int((self.width - 0.5 * pitch) / pitch)
        row, column = np.divmod(np.arange(rows * columns), columns)
        return (column + 0.5 + 0.5 * (row % 2)) * pitch, (row * np.sqrt(3) / 2 + 0.5) * pitch

    def solid_fraction(self, grains: Grains) -> float:
        """Share of area filled by the finest grains, clear of walls, of the rough surface, and of others."""
        margin = MARGIN * self.grain_diameter
        return solid_fraction(
            grains,
            left=max(self.left, 0.0) + margin,
            right=min(self.right, self.width) - margin,
            bottom=max(self.fine_bottom, 0.0) + margin,
            top=self.depth - margin,
        )
