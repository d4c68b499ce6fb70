"""What must be kept among spheres: momentum with the implement, and the weight that the walls carry."""

from dataclasses import replace

import numpy as np

from synth.dem.contact_law import ContactLaw
from synth.dem.grains import Grains, Spheres
from synth.dem.tool import Tool
from synth.implements import Shape
from synth.scene import GRAVITY
from validation.verification.comparison import Comparison, compare
from validation.verification.contact_forces import contact_forces
from validation.verification.discs import DEFAULT, DENSITY, RADIUS, advance_for, law
from validation.verification.spheres import sphere_solver

_KEPT = "closed form: conserved"
_ROUND_OFF = 1e-9
_STIFFNESS = 1000.0
"""N/m."""


def sphere_momentum() -> list[Comparison]:
    """What a wheel among spheres is given is what they lose: momentum, and its moment about the axle."""
    grains = _cloud((6, 3, 4), spacing=2.4e-3, corner=(0.493, 0.1, 0.541), speed=0.05)
    grains = replace(grains, velocity=grains.velocity + np.array([[0.1], [0.0], [-0.3]]))
    wheel = Tool(Shape.disc(0.04), x=0.5, z=0.5, spin=-2.0)
    rough = _rough(implement_friction=0.4, rolling_friction=0.1)
    solver = replace(sphere_solver(grains, rough, steps_per_contact=DEFAULT), tool=wheel)
    advance_for(solver, 0.03)
    given, after = solver.take_tool_impulse(), solver.read_grains()
    lost = (grains.mass * grains.velocity).sum(axis=1) - (after.mass * after.velocity).sum(axis=1)
    turned = _moment(grains) - _moment(after)
    expected = (
        ("momentum along x given to a wheel by spheres, N s", lost[0], given.x),
        ("momentum along z given to a wheel by spheres, N s", lost[2], given.z),
        ("angular momentum given to a wheel by spheres, N m s", turned, given.moment),
    )
    return [
        compare(quantity, reference=reference, measured=measured, limit=_ROUND_OFF, source=_KEPT)
        for quantity, reference, measured in expected
    ]


def sphere_angular_momentum() -> list[Comparison]:
    """Rough spheres that roll on each other with damping, far from anything else: all three components."""
    grains = _cloud((4, 4, 4), spacing=2.2e-3, corner=(0.5, 0.5, 0.5), speed=0.3)
    centre = grains.position.mean(axis=1)
    inwards = 5.0 * (centre[:, None] - grains.position)
    grains = replace(grains, velocity=grains.velocity + inwards, spin=grains.spin + 100.0)
    solver = sphere_solver(grains, _rough(rolling_friction=0.2), steps_per_contact=DEFAULT)
    advance_for(solver, 0.02)
    before, after = (_angular_momentum(one, centre) for one in (grains, solver.read_grains()))
    return [
        compare(
            f"angular momentum of a colliding cloud of spheres about {axis}, N m s",
            reference=was,
            measured=now,
            scale=float(np.linalg.norm(before)),
            limit=_ROUND_OFF,
            source=_KEPT,
        )
        for axis, was, now in zip("xyz", before, after, strict=True)
    ]


def sphere_weight() -> list[Comparison]:
    """A small bed of spheres at rest between rough walls and glass: they carry its weight, and each other."""
    width, thickness = 14e-3, 10e-3
    rough = _rough(wall_friction=0.5, rolling_friction=0.1, glass_friction=0.3)
    loose = _cloud((5, 4, 12), spacing=2.4e-3, corner=(1.3e-3, 1.3e-3, 1.3e-3), speed=0.05)
    solver = sphere_solver(
        loose,
        rough,
        width=width,
        thickness=thickness,
        gravity=(0.0, -GRAVITY),
        steps_per_contact=DEFAULT,
        drag=20.0,
    )
    advance_for(solver, 0.3)
    walls = contact_forces(solver).from_walls.sum(axis=2)
    weight = float(loose.mass.sum()) * GRAVITY
    source = "closed form: a bed at rest is in balance"
    return [
        compare(
            f"forces of all walls on a bed of spheres along {axis}, N",
            reference=reference,
            measured=measured,
            scale=weight,
            limit=0.001,
            source=source,
        )
        for axis, reference, measured in zip("xyz", (0.0, 0.0, weight), walls.sum(axis=0), strict=True)
    ]


def _rough(**changes: float) -> ContactLaw:
    return replace(law(restitution=0.5, friction=0.5, stiffness=_STIFFNESS), **changes)


def _cloud(
    counts: tuple[int, int, int], *, spacing: float, corner: tuple[float, float, float], speed: float
) -> Spheres:
    """Spheres of random size on a cubic lattice with random velocities."""
    rng = np.random.default_rng(5)
    axes = (np.arange(count) * spacing + start for count, start in zip(counts, corner, strict=True))
    position = np.stack([one.ravel() for one in np.meshgrid(*axes, indexing="ij")])
    radius = np.asarray(RADIUS * rng.uniform(0.8, 1.2, position.shape[1]))
    still = Spheres.at_rest(position, radius, DENSITY)
    return replace(still, velocity=rng.normal(0, speed, position.shape))


def _angular_momentum(grains: Grains, about: np.ndarray) -> np.ndarray:
    arm = grains.position - about[:, None]
    orbital = np.cross(arm, grains.mass * grains.velocity, axis=0)
    return np.asarray((orbital + grains.inertia * grains.spin).sum(axis=1))


def _moment(grains: Grains) -> float:
    """Angular momentum about the axle, counter-clockwise as the camera sees it, N m s."""
    return -float(_angular_momentum(grains, np.array([0.5, 0.0, 0.5]))[1])
