"""Two discs, or a disc and the floor, collide: rebound, duration, overlap, gross sliding, rolling impact."""

from dataclasses import replace

import numpy as np

from validation.verification.comparison import Comparison, compare
from validation.verification.discs import (
    DEFAULT,
    FINE,
    MASS,
    RADIUS,
    STIFFNESS,
    advance_for,
    discs_at,
    law,
    solver_of,
)

_SPEED = 0.3
"""m/s."""
_CONTACT_TIME = np.pi * np.sqrt(MASS / 2 / STIFFNESS)
"""Of two elastic discs, s."""
_PHASES = 64
"""Collisions that begin at as many places within a time step."""
_LINEAR = "spring and dashpot without attraction: Schwager and Poeschel, Granular Matter 9 (2007) 465"
_HARMONIC = "closed form: half a period of the harmonic oscillator of the reduced mass"
_RIGID = (
    "closed form: impulses of a rigid disc, compare Chung and Ooi, Granular Matter 13 (2011) 643, tests 4-7"
)
_STICKING = (
    "closed form: two oscillators without damping, compare Walton, in: Particulate Two-Phase Flow (1993) 884"
)
_NO_SLIDING = 1e4
"""Coulomb coefficient."""


def rebound_between_discs() -> list[Comparison]:
    """Rebound / impact speed at several restitutions, resolved finely and as in the shipped scenes.

    Single collisions scatter about the mean, by the phase of a time step at which they begin.
    """
    rows = []
    for steps in (FINE, DEFAULT):
        for restitution in (0.2, 0.5, 0.9):
            rebounds = _rebounds(restitution, steps)
            rows.append(_restitution(f"of two discs, {steps} steps a contact", restitution, rebounds))
            if steps == DEFAULT:
                rows.append(_scatter(restitution, rebounds))
    return rows


def _restitution(of_what: str, asked_for: float, rebounds: np.ndarray) -> Comparison:
    return compare(
        f"restitution {of_what}",
        reference=asked_for,
        measured=float(rebounds.mean()),
        limit=0.005,
        source=_LINEAR,
    )


def _scatter(restitution: float, rebounds: np.ndarray) -> Comparison:
    return compare(
        f"greatest deviation of one collision from that mean of {restitution}",
        reference=0.0,
        measured=float(np.abs(rebounds - rebounds.mean()).max()),
        scale=1.0,
        limit=1 / DEFAULT,
        source="bound of this suite: the share of the collision that is one time step",
    )


def _rebounds(restitution: float, steps: int) -> np.ndarray:
    """Rebound / impact speed of collisions that begin at all phases of a time step."""
    x = np.tile([[0.1], [0.1 + 2 * RADIUS]], _PHASES)
    x[1] += 1e-5 + np.arange(_PHASES) / _PHASES * _SPEED * _CONTACT_TIME / steps
    z = np.tile(0.01 + 6 * RADIUS * np.arange(_PHASES), (2, 1))
    velocity = np.zeros((2, 2 * _PHASES))
    velocity[0, :_PHASES] = _SPEED
    grains = discs_at(np.stack([x.ravel(), z.ravel()]), velocity=velocity)
    solver = solver_of(grains, law(restitution=restitution), steps_per_contact=steps)
    advance_for(solver, 1e-5 / _SPEED + 3 * _CONTACT_TIME)
    first, second = solver.read_grains().velocity[0].reshape(2, _PHASES)
    return np.asarray((second - first) / _SPEED)


def rebound_from_floor() -> list[Comparison]:
    """Rebound / impact speed of discs on the floor, where a collision takes root 2 as many steps."""
    rows = []
    for steps in (FINE, DEFAULT):
        x = 0.01 + 6 * RADIUS * np.arange(_PHASES)
        z = 1.01 * RADIUS + np.arange(_PHASES) / _PHASES * _SPEED * _CONTACT_TIME / steps
        falling = discs_at(np.stack([x, z]), velocity=np.tile([[0.0], [-_SPEED]], _PHASES))
        for restitution in (0.2, 0.5, 0.9):
            solver = solver_of(falling, law(restitution=restitution), steps_per_contact=steps)
            advance_for(solver, 0.01 * RADIUS / _SPEED + 4 * _CONTACT_TIME)
            rebounds = solver.read_grains().velocity[1] / _SPEED
            rows.append(_restitution(f"on the floor, {steps} steps a contact", restitution, rebounds))
    return rows


def elastic_contact() -> list[Comparison]:
    """Duration and greatest overlap of a collision of two elastic discs."""
    grains = discs_at([[0.1, 0.1 + 2 * RADIUS], [0.5, 0.5]], velocity=[[_SPEED, 0.0], [0.0, 0.0]])
    solver = solver_of(grains, law())
    overlaps = [0.0]
    while len(overlaps) < 2 or overlaps[-1] > 0:
        solver.advance(1)
        overlaps.append(2 * RADIUS - float(np.diff(solver.read_grains().position[0])[0]))
    duration = (len(overlaps) - 1) * solver.time_step + overlaps[
        -1
    ] / _SPEED  # they part at the speed they met
    return [
        compare(
            "duration of an elastic collision, s",
            reference=_CONTACT_TIME,
            measured=duration,
            limit=0.002,
            source=_HARMONIC,
        ),
        compare(
            "greatest overlap, m",
            reference=_SPEED * np.sqrt(MASS / 2 / STIFFNESS),
            measured=max(overlaps),
            limit=0.002,
            source=_HARMONIC,
        ),
    ]


def gross_sliding() -> list[Comparison]:
    """A disc slides while it hits the floor: obliquely, and straight down but spinning."""
    friction, restitution, impact = 0.2, 0.6, 0.2
    kick = friction * (1 + restitution) * impact
    oblique = _after_impact(friction, restitution, velocity=(0.5, -impact), spin=0.0)
    spinning = _after_impact(friction, restitution, velocity=(0.0, -impact), spin=-0.6 / RADIUS)
    expected = (
        ("oblique impact: tangential speed, m/s", 0.5 - kick, oblique[0]),
        ("oblique impact: rim speed, m/s", 2 * kick, -oblique[1]),
        ("spinning impact: tangential speed, m/s", kick, spinning[0]),
        ("spinning impact: rim speed, m/s", 0.6 - 2 * kick, -spinning[1]),
    )
    return [
        compare(quantity, reference=reference, measured=measured, limit=0.005, source=_RIGID)
        for quantity, reference, measured in expected
    ]


def rolling_impact() -> list[Comparison]:
    """A disc that nothing lets slide hits the floor obliquely: it rolls off, or its rim is turned back.

    The normal spring takes half a swing with the disc's mass; meanwhile the tangential one swings with a
    third of it (1 / m + R^2 / I = 3 / m). A quarter of a swing takes away the speed at which the rim moves on
    the floor, which is rolling; half a swing reverses it.
    """
    rows = []
    for share, what in ((1 / 12, "rolls off"), (1 / 3, "is turned back")):
        taken = (1 - np.cos(np.pi * np.sqrt(3 * share))) / 3
        found = _after_impact(_NO_SLIDING, 1.0, velocity=(0.5, -0.2), spin=0.0, tangential_share=share)
        for quantity, reference, measured in (
            ("tangential", 0.5 * (1 - taken), found[0]),
            ("rim", 0.5 * 2 * taken, -found[1]),
        ):
            rows.append(
                compare(
                    f"oblique impact of a disc that {what}: {quantity} speed, m/s",
                    reference=reference,
                    measured=measured,
                    limit=0.005,
                    source=_STICKING,
                )
            )
    return rows


def _after_impact(
    friction: float,
    restitution: float,
    *,
    velocity: tuple[float, float],
    spin: float,
    tangential_share: float = 0.5,
) -> tuple[float, float]:
    """Tangential and rim speed of a disc after it has hit the floor, m/s.

    `tangential_share` is tangential stiffness / normal stiffness.
    """
    # A hundred times stiffer, so that the overlap shortens the arm of the friction by little.
    stiff = law(restitution=restitution, wall_friction=friction, stiffness=100 * STIFFNESS)
    stiff = replace(stiff, tangential_stiffness=tangential_share * stiff.normal_stiffness)
    grains = discs_at([[0.5], [1.001 * RADIUS]], velocity=np.array([velocity]).T, spin=spin)
    solver = solver_of(grains, stiff, steps_per_contact=FINE)
    advance_for(solver, 0.001 * RADIUS / abs(velocity[1]) + 0.4 * _CONTACT_TIME)
    after = solver.read_grains()
    return float(after.velocity[0, 0]), float(after.spin[0] * RADIUS)
