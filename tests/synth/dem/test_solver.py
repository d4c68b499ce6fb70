"""Closed-form mechanics: collisions, sliding, rolling, weight, momentum."""

from dataclasses import replace

import numpy as np
import pytest

from synth.dem.contact_law import ContactLaw, damping_ratio_of, largest_time_step
from synth.dem.grains import Grains
from synth.dem.tool import Tool
from synth.devices import start_taichi
from synth.implements import Shape

start_taichi()

from synth.dem.solver import SimulationError, Solver  # noqa: E402 - taichi must be started first

RADIUS, DENSITY, STIFFNESS = 1e-3, 2000.0, 1e6
GRAVITY = 9.81


def law(**changes) -> ContactLaw:
    smooth = ContactLaw(STIFFNESS, 0.5 * STIFFNESS, damping_ratio_of(0.6), 0.0, 0.0, 0.0, 0.0)
    return replace(smooth, **changes)


def grains_at(*centres, velocity=None, radius=RADIUS) -> Grains:
    position = np.array(centres, float).T
    still = Grains.at_rest(position, np.full(position.shape[1], radius), DENSITY)
    return still if velocity is None else replace(still, velocity=np.array(velocity, float).T)


def solver_of(
    grains, contact_law, *, width=1.0, gravity=(0.0, 0.0), steps_per_contact=100, tool=None
) -> Solver:
    step = largest_time_step(grains.mass, contact_law.normal_stiffness, steps_per_contact)
    return Solver(grains, contact_law, width, step, gravity=gravity, tool=tool)


def advance_for(solver, time):
    solver.advance(round(time / solver.time_step))


@pytest.mark.parametrize("restitution", [0.2, 0.6, 0.95])
def test_two_discs_rebound_at_the_restitution_asked_for(restitution):
    grains = grains_at((0.1, 0.5), (0.1021, 0.5), velocity=[(0.2, 0), (-0.1, 0)])
    solver = solver_of(grains, law(damping_ratio=damping_ratio_of(restitution)), steps_per_contact=1000)
    advance_for(solver, 2e-3)
    v1, v2 = solver.read_grains().velocity[0]
    assert v2 - v1 == pytest.approx(restitution * 0.3, rel=3e-3)
    assert v1 + v2 == pytest.approx(0.1, rel=1e-12)  # equal masses: momentum


@pytest.mark.parametrize(
    ("centre", "velocity", "normal"),
    [
        ((0.5, 1.05e-3), (0, -0.2), (0, 1)),
        ((1.05e-3, 0.5), (-0.2, 0), (1, 0)),
        ((0.9989, 0.5), (0.2, 0), (-1, 0)),
    ],
    ids=["floor", "left", "right"],
)
def test_walls_rebound_at_the_restitution_asked_for(centre, velocity, normal):
    solver = solver_of(grains_at(centre, velocity=[velocity]), law())
    advance_for(solver, 3e-3)
    assert solver.read_grains().velocity[:, 0] @ np.array(normal) == pytest.approx(0.6 * 0.2, rel=5e-3)


def test_oblique_impact_slides_as_coulomb_says():
    friction, restitution, vn, vt = 0.2, 0.6, 0.2, 0.5
    grains = grains_at((0.5, 1.05e-3), velocity=[(vt, -vn)])
    stiff = law(normal_stiffness=1e8, tangential_stiffness=5e7, wall_friction=friction)
    solver = solver_of(grains, stiff, steps_per_contact=400)
    advance_for(solver, 3e-3)
    after = solver.read_grains()
    kick = friction * (1 + restitution) * vn
    assert after.velocity[0, 0] == pytest.approx(vt - kick, rel=2e-3)
    # Friction acts backwards below the centre: the disc turns clockwise, which is negative.
    assert after.spin[0] * RADIUS == pytest.approx(-2 * kick, rel=5e-3)


@pytest.mark.parametrize("slope", [0.45, 0.55, 0.8])
def test_block_on_an_incline(slope):
    """A disc that cannot roll (rolling friction above Coulomb friction) is a sliding block."""
    friction, time = 0.5, 0.05
    tilt = np.arctan(slope)
    gravity = (GRAVITY * np.sin(tilt), -GRAVITY * np.cos(tilt))
    rest_height = RADIUS - DENSITY * np.pi * RADIUS**2 * GRAVITY * np.cos(tilt) / STIFFNESS
    grains = grains_at((0.2, rest_height))
    solver = solver_of(grains, law(wall_friction=friction, rolling_friction=1.0), gravity=gravity)
    advance_for(solver, time)
    expected = max(0.0, GRAVITY * (np.sin(tilt) - friction * np.cos(tilt)) * time)
    assert solver.read_grains().velocity[0, 0] == pytest.approx(expected, rel=5e-3, abs=5e-4)


@pytest.mark.parametrize("rolling_friction", [0.0, 0.1, 0.3])
def test_disc_rolling_down_an_incline(rolling_friction):
    tilt, time = np.arctan(0.2), 0.05
    gravity = (GRAVITY * np.sin(tilt), -GRAVITY * np.cos(tilt))
    rest_height = RADIUS - DENSITY * np.pi * RADIUS**2 * GRAVITY * np.cos(tilt) / STIFFNESS
    solver = solver_of(
        grains_at((0.2, rest_height)),
        law(wall_friction=0.9, rolling_friction=rolling_friction),
        gravity=gravity,
    )
    advance_for(solver, time)
    acceleration = max(0.0, GRAVITY * (np.sin(tilt) - rolling_friction * np.cos(tilt)) * 2 / 3)
    assert solver.read_grains().velocity[0, 0] == pytest.approx(acceleration * time, rel=1e-2, abs=2e-4)


def test_sliding_disc_ends_up_rolling_at_two_thirds():
    start, friction = 0.3, 0.3
    rest_height = RADIUS - DENSITY * np.pi * RADIUS**2 * GRAVITY / STIFFNESS
    grains = grains_at((0.2, rest_height), velocity=[(start, 0)])
    solver = solver_of(grains, law(wall_friction=friction), gravity=(0, -GRAVITY))
    advance_for(solver, 2 * start / (3 * friction * GRAVITY))
    after = solver.read_grains()
    assert after.velocity[0, 0] == pytest.approx(2 / 3 * start, rel=5e-3)
    assert after.spin[0] * RADIUS == pytest.approx(-after.velocity[0, 0], rel=5e-3)


def test_floor_carries_the_weight_of_the_bed():
    rng = np.random.default_rng(3)
    x, z = np.meshgrid(np.arange(20) * 2.5e-3 + 1.5e-3, np.arange(8) * 2.5e-3 + 1.5e-3)
    radius = RADIUS * rng.uniform(0.8, 1.2, x.size)
    grains = Grains.at_rest(np.stack([x.ravel(), z.ravel()]), radius, DENSITY)
    frictionless_walls = law(friction=0.5, rolling_friction=0.1)
    step = largest_time_step(grains.mass, STIFFNESS, 20)
    solver = Solver(grains, frictionless_walls, 0.05, step, drag=20.0)
    advance_for(solver, 0.4)
    after = solver.read_grains()
    pushing = np.maximum(after.radius - after.position[1], 0)
    assert STIFFNESS * pushing.sum() == pytest.approx(grains.mass.sum() * GRAVITY, rel=1e-3)


def test_momentum_given_to_the_implement_is_what_the_grains_lost():
    rng = np.random.default_rng(5)
    x, z = np.meshgrid(np.arange(8) * 2.3e-3 + 0.49, np.arange(4) * 2.3e-3 + 0.541)
    grains = Grains.at_rest(np.stack([x.ravel(), z.ravel()]), RADIUS * rng.uniform(0.8, 1.2, x.size), DENSITY)
    grains = replace(grains, velocity=np.tile([[0.1], [-0.3]], x.size))
    tool = Tool(Shape.disc(0.04), x=0.5, z=0.5, mass=3.0, velocity_x=0.05, spin=-2.0, heaves=True)
    rough = law(friction=0.4, implement_friction=0.4, rolling_friction=0.1)
    solver = solver_of(grains, rough, tool=tool, steps_per_contact=50)
    before = (grains.mass * grains.velocity).sum(axis=1)
    advance_for(solver, 0.03)
    impulse, after = solver.take_tool_impulse(), solver.read_grains()
    lost = before - (after.mass * after.velocity).sum(axis=1)
    assert abs(impulse.z) > 0.01 * abs(before[1])
    np.testing.assert_allclose([impulse.x, impulse.z], lost, rtol=1e-9)
    # The axle is driven along x and free along z.
    assert solver.read_tool().velocity_z * tool.mass == pytest.approx(impulse.z, rel=1e-9)


def test_wheel_turning_clockwise_throws_a_grain_backwards():
    grains = grains_at((0.5, 0.46 - 0.99 * RADIUS))
    tool = Tool(Shape.disc(0.04), x=0.5, z=0.5, spin=-5.0)
    solver = solver_of(grains, law(implement_friction=0.5), tool=tool)
    advance_for(solver, 2e-4)
    assert solver.read_grains().velocity[0, 0] < 0
    impulse = solver.take_tool_impulse()
    assert impulse.x > 0  # the grain pushes the wheel forwards
    assert impulse.moment > 0  # and brakes its clockwise turning


def test_slow_grain_far_from_the_origin_creeps():
    speed, step, start = 3.6e-3, 4e-6, 4.0
    solver = Solver(grains_at((start, 0.5), velocity=[(speed, 0)]), law(), 5.0, step, gravity=(0, 0))
    solver.advance(1000)
    moved = solver.read_grains().position[0, 0] - start
    assert moved == pytest.approx(1000 * speed * step, rel=1e-9)


def test_too_large_a_step_stops_with_a_line_that_says_what_to_change():
    grains = grains_at((0.1, 0.5), (0.1005, 0.5))
    solver = Solver(grains, law(), 1.0, 1e-3)
    with pytest.raises(SimulationError, match=r"grain \d moved .*steps_per_contact"):
        solver.advance(100)


BLADE = Shape.chain([(-0.02, 0.0), (0.0, 0.0), (0.02, 0.0)], 2e-3)


@pytest.mark.parametrize("x", [0.49, 0.5, 0.5005, 0.51], ids=["side", "joint", "by the joint", "other side"])
def test_a_chain_rebounds_a_grain_once_wherever_it_hits(x):
    grains = grains_at((x, 0.5 + 3.05e-3), velocity=[(0, -0.2)])
    solver = solver_of(grains, law(), tool=Tool(BLADE, x=0.5, z=0.5))
    advance_for(solver, 3e-3)
    assert solver.read_grains().velocity[1, 0] == pytest.approx(0.6 * 0.2, rel=5e-3)
    impulse = solver.take_tool_impulse()
    weight = DENSITY * np.pi * RADIUS**2
    assert impulse.z == pytest.approx(-weight * 0.2 * 1.6, rel=5e-3)
    assert impulse.moment == pytest.approx((x - 0.5) * impulse.z, abs=1e-9)


def test_a_turning_blade_carries_a_grain_at_its_own_speed():
    """A paddle turning counter-clockwise hits a resting grain at its tip, without friction or damping."""
    grains = grains_at((0.515, 0.5 + 3.2e-3))
    paddle = Tool(BLADE, x=0.5, z=0.5, spin=4.0)
    solver = solver_of(grains, law(damping_ratio=damping_ratio_of(1.0)), tool=paddle)
    advance_for(solver, 0.01)
    # An elastic hit by a massive surface moving at spin x arm sends it off at twice that speed.
    assert np.hypot(*solver.read_grains().velocity)[0] == pytest.approx(2 * 4.0 * 0.015, rel=0.02)


def test_moment_about_the_axle_is_that_of_the_forces_where_they_touch():
    grains = grains_at((0.46 - 0.9 * RADIUS, 0.5), velocity=[(0.3, -0.1)])
    tool = Tool(Shape.disc(0.04), x=0.5, z=0.5)
    solver = solver_of(grains, law(implement_friction=0.3), tool=tool)
    before = grains.mass[0] * grains.velocity[:, 0]
    advance_for(solver, 1e-3)
    after, impulse = solver.read_grains(), solver.take_tool_impulse()
    lost = before - after.mass[0] * after.velocity[:, 0]
    np.testing.assert_allclose([impulse.x, impulse.z], lost, rtol=1e-9)
    assert impulse.moment == pytest.approx(-0.04 * lost[1], rel=0.02)  # lost upwards, 0.04 m to the left
    spun = after.inertia[0] * after.spin[0]
    # Angular momentum about the axle is kept by grain and wheel together.
    position = after.position[:, 0] - (0.5, 0.5)
    orbital = position[0] * after.velocity[1, 0] - position[1] * after.velocity[0, 0]
    start = grains.position[:, 0] - (0.5, 0.5)
    first = start[0] * grains.velocity[1, 0] - start[1] * grains.velocity[0, 0]
    total = after.mass[0] * (orbital - first) + spun + impulse.moment
    assert abs(total) < 1e-3 * abs(impulse.moment)


def test_friction_remembers_its_force_when_neighbours_are_listed_anew():
    """A grain on two others on a slope rests on static friction alone; listing anew must not let it slip."""
    tilt = np.arctan(0.2)
    gravity = (GRAVITY * np.sin(tilt), -GRAVITY * np.cos(tilt))
    grains = grains_at((0.5, RADIUS), (0.5 + 2 * RADIUS, RADIUS), (0.5 + RADIUS, (1 + np.sqrt(3)) * RADIUS))
    rough = law(friction=0.9, wall_friction=0.9, rolling_friction=0.9)
    solver = solver_of(grains, rough, gravity=gravity)
    advance_for(solver, 0.05)
    before = solver.read_grains()
    again = solver_of(before, rough, gravity=gravity)
    again.restore_state(solver.save_state())
    for _ in range(5):
        again._list_neighbours()
        again.advance(8)
    for _ in range(5):
        solver.advance(8)
    np.testing.assert_array_equal(again.read_grains().position, solver.read_grains().position)


def test_the_tools_contacts_remember_too_when_listed_anew():
    rest = DENSITY * np.pi * RADIUS**2 * GRAVITY / STIFFNESS
    tilt = np.arctan(0.2)
    gravity = (GRAVITY * np.sin(tilt), -GRAVITY * np.cos(tilt))
    tool = Tool(BLADE, x=0.5, z=0.5)
    held = law(implement_friction=0.9, rolling_friction=0.9)
    solver = solver_of(grains_at((0.495, 0.5 + 3e-3 - rest)), held, gravity=gravity, tool=tool)
    advance_for(solver, 0.05)
    kept = solver.read_grains().position[0, 0]
    for _ in range(20):
        solver._list_neighbours()
        solver.advance(40)
    assert solver.read_grains().position[0, 0] == pytest.approx(kept, abs=1e-9)


def test_results_do_not_depend_on_the_skin_of_the_neighbour_list():
    rng = np.random.default_rng(5)
    x, z = (one.ravel() for one in np.meshgrid(np.arange(8) + 0.6, np.arange(12) + 0.6))
    grains = Grains.at_rest(2.2 * RADIUS * np.stack([x, z]), RADIUS * rng.uniform(0.8, 1.2, x.size), DENSITY)
    grains = replace(grains, velocity=rng.normal(0, 0.2, grains.position.shape))
    ends = []
    for skin in (0.1, 0.15, 0.5):
        solver = Solver(grains, law(rolling_friction=0.2), 20 * RADIUS, 2e-6, skin=skin)
        solver.advance(6000)
        end = solver.read_grains()
        ends.append([end.position, end.velocity, end.angle, end.spin])
    for other in ends[1:]:
        for mine, theirs in zip(ends[0], other, strict=True):
            np.testing.assert_array_equal(mine, theirs)
