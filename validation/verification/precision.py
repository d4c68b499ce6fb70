"""What numbers on a machine could spoil: slow motion far from the origin, and the order of sums."""

import hashlib
import subprocess
import sys

import numpy as np

from synth.dem.solver import Solver
from synth.devices import start_taichi
from validation.verification.comparison import Comparison, compare
from validation.verification.discs import DEFAULT, DENSITY, RADIUS, advance_for, discs_at, law, solver_of
from validation.verification.packing import DIAMETER, Box
from validation.verification.spheres import sphere_solver, spheres_at

_START, _SPEED = 4.0, 3.6e-3
"""Place of a slow grain along the bin, m, and its speed, m/s."""


def slow_creep() -> list[Comparison]:
    """A disc that moves by a hundred-millionth of its place in a step still gets there."""
    disc = discs_at([[_START], [0.5]], velocity=[[_SPEED], [0.0]])
    return [_creep("grain", solver_of(disc, law(), width=5.0, steps_per_contact=DEFAULT))]


def sphere_creep() -> list[Comparison]:
    """The same of a sphere, with contacts as stiff as a bed's."""
    sphere = spheres_at([[_START], [0.5], [0.5]], RADIUS, DENSITY, velocity=[[_SPEED], [0.0], [0.0]])
    return [_creep("sphere", sphere_solver(sphere, law(stiffness=2000.0), steps_per_contact=DEFAULT))]


def _creep(kind: str, solver: Solver) -> Comparison:
    solver.advance(1000)
    return compare(
        f"way of a slow {kind} {_START:g} m from the origin, m",
        reference=_SPEED * solver.time,
        measured=solver.read_grains().position[0, 0] - _START,
        limit=1e-6,
        source="closed form: uniform motion",
    )


def threads() -> list[Comparison]:
    """The same collapse on one thread and on two, each in a process of its own."""
    one, two = (_digest_with(count) for count in (1, 2))
    return [
        compare(
            "bytes that differ between SHA-256 on one thread and on two",
            reference=0.0,
            measured=sum(a != b for a, b in zip(one, two, strict=True)),
            scale=len(one),
            limit=0.0,
            source="sums in a fixed order",
        )
    ]


def _digest_with(thread_count: int) -> bytes:
    code = f"from validation.verification.precision import print_digest; print_digest({thread_count})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return bytes.fromhex(done.stdout.split()[-1])


def print_digest(thread_count: int) -> None:
    """Print the SHA-256 of places and velocities after a small collapse."""
    start_taichi(threads=thread_count)
    box = Box(20 * DIAMETER)
    rough = law(restitution=0.5, friction=0.5, wall_friction=0.5, rolling_friction=0.1)
    solver = box.solver(box.lattice(400, seed=2), rough)
    advance_for(solver, 0.02)
    after = solver.read_grains()
    state = np.concatenate([after.position, after.velocity, [after.angle], [after.spin]])
    print(hashlib.sha256(state.tobytes()).hexdigest())  # noqa: T201 - read by the process that asked
