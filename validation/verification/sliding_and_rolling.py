"""A disc on the floor: it sticks, slides, rolls, and is held by rolling friction."""

import numpy as np

from synth.dem.solver import Solver
from synth.scene import GRAVITY
from validation.verification.comparison import Comparison, compare
from validation.verification.discs import (
    MASS,
    RADIUS,
    STIFFNESS,
    advance_for,
    discs_at,
    law,
    resting_height,
    solver_of,
)

_STEPS = 100
"""Time steps in a collision."""
_FROM, _TO = 0.01, 0.06
"""Times between which a disc on an incline is looked at, s: at first, springs are wound up."""
_RIGID = "closed form: a rigid body under Coulomb friction"
_ROLLING = "closed form: a rigid disc under a rolling moment of at most coefficient x normal force x radius"


def block_on_incline() -> list[Comparison]:
    """A disc that cannot roll, on slopes below and above its friction angle.

    Rolling friction above Coulomb friction makes a sliding block of it.
    """
    friction = 0.5
    rows = []
    for slope in (0.45, 0.55, 0.8):
        tilt = np.arctan(slope)
        speed = max(0.0, GRAVITY * (np.sin(tilt) - friction * np.cos(tilt)) * (_TO - _FROM))
        rows.append(
            compare(
                f"speed gained by a block, friction {friction}, slope {slope}, m/s",
                reference=speed,
                measured=_speed_gained(tilt, friction=friction, rolling_friction=1.0),
                limit=0.005,
                scale=speed or GRAVITY * np.sin(tilt) * (_TO - _FROM),
                source=_RIGID,
            )
        )
    return rows


def disc_on_incline() -> list[Comparison]:
    """A disc rolls down a slope: freely, slowed by rolling friction, and not at all."""
    slope = 0.2
    tilt = np.arctan(slope)
    rows = []
    for rolling_friction in (0.0, 0.1, 0.3):
        drive = max(0.0, np.sin(tilt) - rolling_friction * np.cos(tilt))
        speed = 2 / 3 * GRAVITY * drive * (_TO - _FROM)
        rows.append(
            compare(
                f"speed gained by a disc, rolling friction {rolling_friction}, slope {slope}, m/s",
                reference=speed,
                measured=_speed_gained(tilt, friction=0.9, rolling_friction=rolling_friction),
                limit=0.01,
                scale=speed or 2 / 3 * GRAVITY * np.sin(tilt) * (_TO - _FROM),
                source=_ROLLING,
            )
        )
    return rows


def _speed_gained(tilt: float, *, friction: float, rolling_friction: float) -> float:
    """Speed that a disc gains after it was laid on a slope at rest, m/s."""
    gravity = (GRAVITY * np.sin(tilt), -GRAVITY * np.cos(tilt))
    grains = discs_at([[0.2], [resting_height(-MASS * gravity[1])]])
    rough = law(restitution=0.6, wall_friction=friction, rolling_friction=rolling_friction)
    solver = solver_of(grains, rough, gravity=gravity, steps_per_contact=_STEPS)
    advance_for(solver, _FROM)
    first = solver.read_grains().velocity[0, 0]
    advance_for(solver, _TO - _FROM)
    return float(solver.read_grains().velocity[0, 0] - first)


def sliding_to_rolling() -> list[Comparison]:
    """A disc that is thrown along the floor ends up rolling."""
    start, friction = 0.3, 0.3
    grains = discs_at([[0.2], [resting_height(MASS * GRAVITY)]], velocity=[[start], [0.0]])
    rough = law(restitution=0.6, wall_friction=friction)
    solver = solver_of(grains, rough, gravity=(0.0, -GRAVITY), steps_per_contact=_STEPS)
    rolls_after = start / (3 * friction * GRAVITY)
    advance_for(solver, 0.5 * rolls_after)
    sliding = solver.read_grains().velocity[0, 0]
    advance_for(solver, 1.5 * rolls_after)
    after = solver.read_grains()
    expected = (
        ("speed half-way to rolling, m/s", 5 / 6 * start, sliding),
        ("speed while rolling, m/s", 2 / 3 * start, after.velocity[0, 0]),
        ("rim speed while rolling, m/s", 2 / 3 * start, -after.spin[0] * RADIUS),
    )
    return [
        compare(quantity, reference=reference, measured=measured, limit=0.005, source=_RIGID)
        for quantity, reference, measured in expected
    ]


def tangential_spring() -> list[Comparison]:
    """A disc swings about its contact with the floor, held by the tangential spring alone.

    Its rim's slip obeys ``u'' = -3 (k_t / m) u``: one third of it is translation, two are rotation. What the
    spring remembers must neither be lost nor grow over many swings.
    """
    swing = 2 * np.pi * np.sqrt(MASS / (3 * 0.5 * STIFFNESS))
    # No more than a fifth of Coulomb's limit is used.
    speed = 0.2 * MASS * GRAVITY / np.sqrt(3 * MASS * 0.5 * STIFFNESS)
    grains = discs_at(
        [[0.2], [resting_height(MASS * GRAVITY)]], velocity=[[speed], [0.0]], spin=2 * speed / RADIUS
    )
    solver = solver_of(grains, law(wall_friction=1.0), gravity=(0.0, -GRAVITY), steps_per_contact=400)
    times, speeds = _swings(solver, 20 * swing)
    down = np.flatnonzero((speeds[:-1] > 0) & (speeds[1:] <= 0))
    crossing = times[down] + (times[1] - times[0]) * speeds[down] / (speeds[down] - speeds[down + 1])
    last = speeds[times > times[-1] - 2 * swing]
    source = "closed form: harmonic oscillator of a rigid disc on a tangential spring"
    return [
        compare(
            "period of a disc on its tangential spring, s",
            reference=swing,
            measured=float(np.diff(crossing).mean()),
            limit=0.005,
            source=source,
        ),
        compare(
            "its amplitude after 20 swings, m/s",
            reference=speed,
            measured=float(np.abs(last).max()),
            limit=0.01,
            source=source,
        ),
    ]


def _swings(solver: Solver, time: float) -> tuple[np.ndarray, np.ndarray]:
    """Times, s, and speeds along the floor of the only disc, m/s."""
    times, speeds = [], []
    while solver.time < time:
        solver.advance(8)
        times.append(solver.time)
        speeds.append(solver.read_grains().velocity[0, 0])
    return np.array(times), np.array(speeds)
