"""Many discs at rest in a box, poured and left to settle."""

from dataclasses import replace

import numpy as np

from synth.dem.contact_law import ContactLaw
from synth.dem.grains import Grains
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


def loose_lattice(count: int, width: float, *, seed: int, bottom: float = 0.0) -> Grains:
    """Discs of random size on a lattice that fills about 0.62 of the area, with small random velocities.

    Parameters
    ----------
    width : float
        Of the box, m.
    bottom : float
        Where the lattice begins, m.
    """
    rng = np.random.default_rng(seed)
    radius = DIAMETER / 2 * rng.uniform(1 - POLYDISPERSITY, 1 + POLYDISPERSITY, count)
    columns = int((width - 0.5 * _PITCH) / _PITCH)
    row, column = np.divmod(np.arange(count), columns)
    slack = (width - 0.5 * _PITCH) / columns
    x = (column + 0.5) * slack + 0.5 * _PITCH * (row % 2)
    z = bottom + (row * np.sqrt(3) / 2 + 0.5) * _PITCH
    grains = Grains.at_rest(np.stack([x, z]), radius, DENSITY)
    return replace(grains, velocity=rng.normal(0, 0.05, grains.position.shape))


def time_to_fall(grains: Grains) -> float:
    """Time in which the lattice has fallen together, with a third to spare, s."""
    drop = 0.25 * float(np.ptp(grains.position[1]))
    return 1.33 * float(np.sqrt(2 * drop / GRAVITY))


def settled(count: int, width: float, law: ContactLaw, *, seed: int) -> Grains:
    """Discs poured between walls `width` apart (m) and at rest under gravity."""
    falling = loose_lattice(count, width, seed=seed)
    gravity = (0.0, -GRAVITY)
    solver = solver_of(falling, law, width=width, gravity=gravity, steps_per_contact=DEFAULT)
    advance_for(solver, time_to_fall(falling))
    solver = solver_of(
        solver.read_grains(), law, width=width, gravity=gravity, steps_per_contact=DEFAULT, drag=_DRAG
    )
    advance_for(solver, _REST)
    rested = solver.read_grains()
    return Grains.at_rest(rested.position, rested.radius, rested.density)
