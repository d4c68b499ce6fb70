"""What numbers on a machine could spoil: slow motion far from the origin, and the order of sums."""

import hashlib
import subprocess
import sys

import numpy as np

from synth.devices import start_taichi
from synth.scene import GRAVITY
from validation.verification.comparison import Comparison, compare
from validation.verification.discs import DEFAULT, advance_for, discs_at, law, solver_of
from validation.verification.packing import DIAMETER, loose_lattice


def slow_creep() -> list[Comparison]:
    """A grain that moves by a hundred-millionth of its place in a step still gets there."""
    start, speed = 4.0, 3.6e-3
    solver = solver_of(
        discs_at([[start], [0.5]], velocity=[[speed], [0.0]]), law(), width=5.0, steps_per_contact=DEFAULT
    )
    solver.advance(1000)
    return [
        compare(
            "way of a slow grain 4 m from the origin, m",
            reference=speed * solver.time,
            measured=solver.read_grains().position[0, 0] - start,
            limit=1e-6,
            source="closed form: uniform motion",
        )
    ]


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
    grains = loose_lattice(400, 20 * DIAMETER, seed=2)
    rough = law(restitution=0.5, friction=0.5, wall_friction=0.5, rolling_friction=0.1)
    solver = solver_of(grains, rough, width=20 * DIAMETER, gravity=(0.0, -GRAVITY), steps_per_contact=DEFAULT)
    advance_for(solver, 0.02)
    after = solver.read_grains()
    state = np.concatenate([after.position, after.velocity, [after.angle], [after.spin]])
    print(hashlib.sha256(state.tobytes()).hexdigest())  # noqa: T201 - read by the process that asked
