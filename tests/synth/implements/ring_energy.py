"""Energy of an elastic rim, by another way than the product's."""

import numpy as np

from synth.implements.ring import Ring


def elastic_energy(ring: Ring, nodes: np.ndarray) -> float:
    """Energy of the springs, bars and hinges of a ring with `nodes` (N, 2) in the hub's frame, J/m."""
    place, unloaded = nodes @ (1, 1j), ring.unloaded @ (1, 1j)
    moved = (place - unloaded) * unloaded.conj() / ring.node_radius  # outwards and along the rim
    bar = np.roll(place, -1) - place
    turn = np.angle(bar / np.roll(bar, 1))
    return 0.5 * float(
        ring.radial_stiffness * (moved.real**2).sum()
        + ring.tangential_stiffness * (moved.imag**2).sum()
        + ring.hoop_stiffness * ((np.abs(bar) - ring.bar_length) ** 2).sum()
        + ring.bending_stiffness * ((turn - ring.hinge_angle) ** 2).sum()
    )
