"""Many grains at rest in a box, poured and left to settle: discs in a plane, or spheres between glass."""

from dataclasses import dataclass, replace

import numpy as np

from synth.dem.contact_law import ContactLaw
from synth.dem.grains import Grains, Spheres
from synth.dem.packing import slab_solid_fraction, solid_fraction, void_ratio
from synth.dem.solver import SKIN, Solver
from synth.dem.tool import Tool
from synth.scene import GRAVITY
from validation.verification.discs import DEFAULT, DENSITY, advance_for, solver_of

DIAMETER = 2e-3
"""Mean, m."""
POLYDISPERSITY = 0.2
"""Diameters are spread evenly over the mean +- this share, against crystallisation."""
_PITCH = 1.01 * DIAMETER * (1 + POLYDISPERSITY)
_DRAG = 100.0
"""Rate at which motion dies away while the last of it is taken out, 1/s."""
_REST = 0.06
"""Time for that, s."""
FALLING_SKIN = 0.4
"""Of neighbour lists / mean grain diameter: grains that fall are soon somewhere else."""


@dataclass(frozen=True)
class Box:
    """Where grains are poured.

    Attributes
    ----------
    width : float
        Between the end walls, m.
    thickness : float or None
        Of a slab of spheres, between two panes of glass, m; None: discs, and everything per metre of width.
    """

    width: float
    thickness: float | None = None

    @property
    def depth(self) -> float:
        """Across the plane, m: of discs, the metre that everything is per."""
        return 1.0 if self.thickness is None else self.thickness

    @property
    def solid_fraction(self) -> float:
        """About that of settled grains."""
        return 0.8 if self.thickness is None else 0.6

    def area_of(self, count: int) -> float:
        """About the area, seen across the plane, that so many settled grains fill, m2."""
        if self.thickness is None:
            return count * np.pi / 4 * DIAMETER**2 / self.solid_fraction
        return count * np.pi / 6 * DIAMETER**3 / self.solid_fraction / self.thickness

    def stiffness(self, modulus: float) -> float:
        """Stiffness of contacts that a pressure squeezes by pressure / modulus (Pa) of a diameter, N/m."""
        return modulus if self.thickness is None else modulus * DIAMETER

    def lattice(self, count: int, *, seed: int, bottom: float = 0.0) -> Grains:
        """Grains of random size on a loose lattice, with small random velocities.

        Parameters
        ----------
        bottom : float
            Where the lattice begins, m.
        """
        rng = np.random.default_rng(seed)
        radius = DIAMETER / 2 * rng.uniform(1 - POLYDISPERSITY, 1 + POLYDISPERSITY, count)
        places = self._disc_places(count) if self.thickness is None else self._sphere_places(count)
        places[-1] += bottom
        kind = Grains if self.thickness is None else Spheres
        grains = kind.at_rest(places, radius, DENSITY)
        return replace(grains, velocity=rng.normal(0, 0.05, grains.position.shape))

    def _disc_places(self, count: int) -> np.ndarray:
        """Hexagonal: about 0.62 of the area is filled."""
        columns = int((self.width - 0.5 * _PITCH) / _PITCH)
        row, column = np.divmod(np.arange(count), columns)
        slack = (self.width - 0.5 * _PITCH) / columns
        x = (column + 0.5) * slack + 0.5 * _PITCH * (row % 2)
        return np.stack([x, (row * np.sqrt(3) / 2 + 0.5) * _PITCH])

    def _sphere_places(self, count: int) -> np.ndarray:
        """Cubic: about 0.3 of the volume is filled."""
        along, across = int(self.width / _PITCH), int(self.depth / _PITCH)
        layer, place = np.divmod(np.arange(count), along * across)
        row, column = np.divmod(place, along)
        x, y = (column + 0.5) * self.width / along, (row + 0.5) * self.depth / across
        return np.stack([x, y, (layer + 0.5) * _PITCH])

    def time_to_fall(self, grains: Grains) -> float:
        """Time in which the lattice has fallen together, with a third to spare, s."""
        share = 0.25 if self.thickness is None else 0.55
        drop = share * float(np.ptp(grains.position[-1]))
        return 1.33 * float(np.sqrt(2 * drop / GRAVITY))

    def solver(
        self,
        grains: Grains,
        law: ContactLaw,
        *,
        gravity: float = GRAVITY,
        drag: float = 0.0,
        tool: Tool | None = None,
        skin: float = SKIN,
    ) -> Solver:
        """Grains in the box, at the time step of the shipped scenes; `skin` as of `Solver`."""
        return solver_of(
            grains,
            law,
            width=self.width,
            thickness=np.inf if self.thickness is None else self.thickness,
            gravity=(0.0, -gravity),
            steps_per_contact=DEFAULT,
            drag=drag,
            tool=tool,
            skin=skin,
        )

    def void_ratio(self, grains: Grains, *, left: float, right: float, bottom: float, top: float) -> float:
        """Voids / grains between bounds in the plane (m); of spheres, over the whole depth."""
        bounds = {"left": left, "right": right, "bottom": bottom, "top": top}
        if isinstance(grains, Spheres):
            return void_ratio(slab_solid_fraction(grains, **bounds, thickness=self.depth))
        return void_ratio(solid_fraction(grains, **bounds))

    def settled(self, count: int, law: ContactLaw, *, seed: int) -> Grains:
        """Grains poured between the end walls and at rest under gravity."""
        falling = self.lattice(count, seed=seed)
        solver = self.solver(falling, law, skin=FALLING_SKIN)
        advance_for(solver, self.time_to_fall(falling))
        solver = self.solver(solver.read_grains(), law, drag=_DRAG)
        advance_for(solver, _REST)
        return moved(solver.read_grains())


def moved(grains: Grains, *, x: float = 0.0, z: float = 0.0) -> Grains:
    """The grains at rest, further right and up (m)."""
    places = grains.position.copy()
    places[0] += x
    places[-1] += z
    return type(grains).at_rest(places, grains.radius, grains.density)
