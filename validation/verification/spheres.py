"""Spheres to verify with, few enough to be followed one by one."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from synth.dem.contact_law import HertzMindlinLaw, Law, Material, reduced_moduli
from synth.dem.grains import Spheres
from synth.dem.solver import Solver
from validation.verification.discs import solver_of


def hertzian(
    material: Material,
    *,
    impact_speed: float,
    restitution: float = 1.0,
    friction: float = 0.0,
    wall: Material | None = None,
) -> HertzMindlinLaw:
    """Spheres of a material, walls of another, or rigid ones; one friction for all."""
    return HertzMindlinLaw(
        *reduced_moduli(material, material),
        *reduced_moduli(material, wall),
        restitution=restitution,
        impact_speed=impact_speed,
        friction=friction,
        wall_friction=friction,
        implement_friction=friction,
        rolling_friction=0.0,
    )


def spheres_at(
    centres: Any, radius: ArrayLike, density: float, *, velocity: Any = 0.0, spin: Any = 0.0
) -> Spheres:
    """Spheres of given centres, velocities and spins, shape (3, N), in SI units."""
    centres = np.asarray(centres, float)
    still = Spheres.at_rest(centres, np.broadcast_to(radius, centres.shape[1]).astype(float), density)
    return replace(still, velocity=still.velocity + np.asarray(velocity), spin=still.spin + np.asarray(spin))


def sphere_solver(
    grains: Spheres,
    law: Law,
    *,
    width: float = 100.0,
    thickness: float = 100.0,
    gravity: tuple[float, float] = (0.0, 0.0),
    steps_per_contact: int,
    drag: float = 0.0,
) -> Solver:
    """As `solver_of`, with room enough to be far from the walls."""
    return solver_of(
        grains,
        law,
        width=width,
        thickness=thickness,
        gravity=gravity,
        steps_per_contact=steps_per_contact,
        drag=drag,
    )
