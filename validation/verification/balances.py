"""What must be kept: energy, momentum, angular momentum, and the weight that the walls carry."""

from dataclasses import replace

import numpy as np

from synth.dem.grains import Grains
from synth.dem.solver import Solver
from synth.dem.tool import Tool
from synth.implements import Shape
from synth.scene import GRAVITY
from validation.verification.comparison import Comparison, compare
from validation.verification.contact_forces import X, Z, contact_forces
from validation.verification.discs import DEFAULT, DENSITY, RADIUS, STIFFNESS, advance_for, law, solver_of
from validation.verification.packing import DIAMETER, Box

_KEPT = "closed form: conserved"
_ROUND_OFF = 1e-9


def energy() -> list[Comparison]:
    """Elastic discs without friction fly about in a box for many collisions."""
    grains = _cloud(6, 6, spacing=3e-3, speed=0.1)
    solver = solver_of(grains, law(), width=0.02, steps_per_contact=DEFAULT)
    roof = Tool(Shape.chain(np.array([(-0.01, 0.0), (0.03, 0.0)]), RADIUS), x=0.0, z=0.021)
    solver = replace(solver, tool=roof)
    start = _energy(solver)
    drift = 0.0
    for _ in range(20):
        advance_for(solver, 0.01)
        drift = max(drift, _energy(solver) / start - 1, 1 - _energy(solver) / start)
    return [
        compare(
            "energy of elastic discs after 0.2 s of collisions / before, farthest from 1",
            reference=1.0,
            measured=1 + drift,
            limit=0.01,
            source=_KEPT,
        )
    ]


def _energy(solver: Solver) -> float:
    """Kinetic energy and that of springs between grains and at floor and walls, J/m."""
    grains = solver.read_grains()
    kinetic = 0.5 * float((grains.mass * (grains.velocity**2).sum(axis=0)).sum())
    (x, z), radius = grains.position, grains.radius
    walls = np.maximum(0, np.stack([radius - z, radius - x, x + radius - solver.width]))
    assert solver.tool is not None
    roof = np.maximum(0, z + radius - (solver.tool.z - RADIUS))
    springs = (solver.contacts()[1] ** 2).sum() + (walls**2).sum() + (roof**2).sum()
    return kinetic + 0.5 * STIFFNESS * float(springs)


def momentum_with_implement() -> list[Comparison]:
    """What a wheel among grains is given is what they lose: momentum, and angular momentum about the axle."""
    grains = _cloud(8, 4, spacing=2.3e-3, speed=0.05, corner=(0.49, 0.541))
    grains = replace(grains, velocity=grains.velocity + np.array([[0.1], [-0.3]]))
    wheel = Tool(Shape.disc(0.04), x=0.5, z=0.5, spin=-2.0)
    rough = law(restitution=0.6, friction=0.4, implement_friction=0.4, rolling_friction=0.1)
    solver = solver_of(grains, rough, tool=wheel, steps_per_contact=DEFAULT)
    advance_for(solver, 0.03)
    given, after = solver.take_tool_impulse(), solver.read_grains()
    lost = _momentum(grains) - _momentum(after)
    turned = _angular_momentum(grains, (0.5, 0.5)) - _angular_momentum(after, (0.5, 0.5))
    expected = (
        ("momentum along x given to a wheel, N s/m", lost[0], given.x),
        ("momentum along z given to a wheel, N s/m", lost[1], given.z),
        ("angular momentum given to a wheel, N s", turned, given.moment),
    )
    return [
        compare(quantity, reference=reference, measured=measured, limit=_ROUND_OFF, source=_KEPT)
        for quantity, reference, measured in expected
    ]


def angular_momentum() -> list[Comparison]:
    """Rough discs that roll on each other with damping, far from anything else."""
    grains = _cloud(6, 6, spacing=2.2e-3, speed=0.3, corner=(0.5, 0.5))
    centre = grains.position.mean(axis=1)
    inwards = 5.0 * (centre[:, None] - grains.position)
    grains = replace(grains, velocity=grains.velocity + inwards, spin=grains.spin + 100.0)
    rough = law(restitution=0.5, friction=0.5, rolling_friction=0.2)
    solver = solver_of(grains, rough, steps_per_contact=DEFAULT)
    advance_for(solver, 0.02)
    after = solver.read_grains()
    # Relative to the sum of magnitudes: the sums themselves nearly cancel.
    scale = float(np.abs(grains.mass * np.hypot(*grains.velocity)).sum())
    drift = _momentum(after) - _momentum(grains)
    about = (float(centre[0]), float(centre[1]))
    return [
        compare(
            "momentum of a colliding cloud: change, N s/m",
            reference=0.0,
            measured=float(np.hypot(*drift)),
            scale=scale,
            limit=_ROUND_OFF,
            source=_KEPT,
        ),
        compare(
            "angular momentum of a colliding cloud, N s",
            reference=_angular_momentum(grains, about),
            measured=_angular_momentum(after, about),
            limit=_ROUND_OFF,
            source=_KEPT,
        ),
    ]


def weight_on_walls() -> list[Comparison]:
    """A small bed at rest between rough walls: floor and walls carry its weight, and the walls each other."""
    box = Box(20 * DIAMETER)
    rough = law(restitution=0.3, friction=0.5, wall_friction=0.5, rolling_friction=0.1)
    grains = box.settled(300, rough, seed=4)
    solver = box.solver(grains, rough, drag=100.0)
    advance_for(solver, 0.1)
    walls = contact_forces(solver).from_walls.sum(axis=2)
    weight = float(grains.mass.sum()) * GRAVITY
    source = "closed form: a bed at rest is in balance"
    return [
        compare(
            "floor and walls carry the weight, N/m",
            reference=weight,
            measured=walls[:, Z].sum(),
            limit=0.001,
            source=source,
        ),
        compare(
            "horizontal forces of floor and walls, N/m",
            reference=0.0,
            measured=walls[:, X].sum(),
            scale=weight,
            limit=0.001,
            source=source,
        ),
    ]


def _cloud(
    columns: int, rows: int, *, spacing: float, speed: float, corner: tuple[float, float] = (2e-3, 2e-3)
) -> Grains:
    """Discs of random size on a square lattice with random velocities."""
    rng = np.random.default_rng(5)
    x, z = np.meshgrid(np.arange(columns) * spacing + corner[0], np.arange(rows) * spacing + corner[1])
    radius = RADIUS * rng.uniform(0.8, 1.2, x.size)
    still = Grains.at_rest(np.stack([x.ravel(), z.ravel()]), radius, DENSITY)
    return replace(still, velocity=rng.normal(0, speed, still.position.shape))


def _momentum(grains: Grains) -> np.ndarray:
    return (grains.mass * grains.velocity).sum(axis=1)


def _angular_momentum(grains: Grains, about: tuple[float, float]) -> float:
    """Counter-clockwise, N s."""
    x, z = grains.position - np.array(about)[:, None]
    orbital = grains.mass * (x * grains.velocity[1] - z * grains.velocity[0])
    return float((orbital + grains.inertia * grains.spin).sum())
