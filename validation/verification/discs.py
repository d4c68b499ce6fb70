"""Discs to verify with, few enough to be followed one by one."""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from synth.dem.contact_law import ContactLaw, Law, damping_ratio_of, time_step_of
from synth.dem.grains import Grains
from synth.dem.solver import SKIN, Solver
from synth.dem.tool import Tool

RADIUS = 1e-3
"""m."""
DENSITY = 2000.0
"""kg/m3."""
STIFFNESS = 1e6
"""N/m per metre of width."""
MASS = DENSITY * np.pi * RADIUS**2
"""Of a disc, kg/m."""
FINE = 1000
"""Time steps in a collision where the law itself is looked at, and not how finely it is resolved."""
DEFAULT = 20
"""Time steps in a collision of the shipped scenes."""


def law(
    *,
    restitution: float = 1.0,
    friction: float = 0.0,
    wall_friction: float = 0.0,
    implement_friction: float = 0.0,
    glass_friction: float = 0.0,
    rolling_friction: float = 0.0,
    stiffness: float = STIFFNESS,
) -> ContactLaw:
    """Linear contacts, half as stiff along the tangent as along the normal; both panes of glass are alike."""
    return ContactLaw(
        normal_stiffness=stiffness,
        tangential_stiffness=0.5 * stiffness,
        damping_ratio=damping_ratio_of(restitution),
        friction=friction,
        wall_friction=wall_friction,
        implement_friction=implement_friction,
        rolling_friction=rolling_friction,
        glass_friction=glass_friction,
        back_friction=glass_friction,
    )


def discs_at(centres: ArrayLike, *, velocity: ArrayLike = 0.0, spin: ArrayLike = 0.0) -> Grains:
    """Equal discs.

    Parameters
    ----------
    centres : array_like, shape (2, N)
        m.
    velocity : array_like, shape (2, N)
        m/s.
    spin : array_like, shape (N,)
        rad/s.
    """
    still = Grains.at_rest(np.asarray(centres, float), np.full(np.shape(centres)[1], RADIUS), DENSITY)
    return replace(still, velocity=still.velocity + np.asarray(velocity), spin=still.spin + np.asarray(spin))


def solver_of(
    grains: Grains,
    contact_law: Law,
    *,
    width: float = 1.0,
    thickness: float = np.inf,
    gravity: tuple[float, float] = (0.0, 0.0),
    steps_per_contact: int = FINE,
    drag: float = 0.0,
    tool: Tool | None = None,
    skin: float = SKIN,
) -> Solver:
    """A solver that resolves the shortest collision in so many steps."""
    step = time_step_of(grains, contact_law, steps_per_contact)
    return Solver(
        grains,
        contact_law,
        width,
        step,
        gravity=gravity,
        drag=drag,
        tool=tool,
        thickness=thickness,
        skin=skin,
    )


def advance_for(solver: Solver, time: float) -> None:
    """Take the steps that make so much time, s."""
    solver.advance(max(1, round(time / solver.time_step)))


def resting_height(weight: float) -> float:
    """Height of the centre of a disc that presses on the floor with `weight` (N/m), m."""
    return RADIUS - weight / STIFFNESS
