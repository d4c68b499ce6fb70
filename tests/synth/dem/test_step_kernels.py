"""Steps shared among threads: the same bytes however many there are, and whenever they come or leave."""

import subprocess
import sys

import numpy as np
import pytest

from synth.dem.neighbours import list_neighbours
from synth.dem.sharing import Shares

PROGRAM = """
import hashlib, sys
from dataclasses import replace
import numpy as np
from synth.devices import start_taichi
start_taichi(threads={threads})
from synth.dem import step_kernels
step_kernels._PATIENCE = {patience}
from synth.dem.contact_law import ContactLaw
from synth.dem.grains import Grains, Spheres
from synth.dem.solver import Solver
from synth.dem.tool import Tool
from synth.implements import Shape

rng = np.random.default_rng(4)
stiffness = 1e3 if {spheres} else 1e6
law = ContactLaw(stiffness, stiffness / 2, 0.2, 0.4, 0.3, 0.3, 0.1)
i, j = (one.ravel() for one in np.meshgrid(np.arange(40), np.arange(15)))
place = np.stack([i, j]) + 0.6 + 0.2 * rng.uniform(size=(2, i.size))
radius = 1e-3 * rng.uniform(0.8, 1.2, i.size)
if {spheres}:
    place = np.stack([place[0], 0.9 + 0.2 * rng.uniform(size=i.size), place[1]])
kind = Spheres if {spheres} else Grains
grains = kind.at_rest(2.1e-3 * place, radius, 2000.0)
grains = replace(grains, velocity=rng.normal(0, 0.2, grains.position.shape))
wheel = Tool(Shape.disc(0.02), x=0.04, z=0.0535, velocity_z=-2.0, spin=-20.0)
slab = {{"thickness": 5e-3}} if {spheres} else {{}}
solver = Solver(grains, law, 0.09, 2e-6, tool=wheel, **slab)
solver._workers = solver._workers if {workers} is None else {workers}
solver._board = solver._array(np.zeros(step_kernels.board_size(solver._workers), np.int32))
solver._put_lists_on_device()
solver.advance(501)
end, impulse = solver.read_grains(), solver.take_tool_impulse()
values = (end.position, end.velocity, end.angle, end.spin, np.array([impulse.x, impulse.z, impulse.moment]))
assert impulse.z != 0
print(solver._workers, hashlib.sha256(b"".join(value.tobytes() for value in values)).hexdigest())
"""


def finished(*, threads, workers=None, patience=2000, spheres=False):
    """Workers there were, and the digest of what came out."""
    program = PROGRAM.format(threads=threads, workers=workers, patience=patience, spheres=spheres)
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return done.stdout.split()[-2:]


@pytest.fixture(scope="module")
def alone():
    return finished(threads=1)


@pytest.mark.parametrize("threads", [2, 4])
def test_same_bytes_on_any_number_of_threads_also_beyond_the_cores(alone, threads):
    assert alone[0] == "1"
    assert finished(threads=threads) == [str(threads), alone[1]]


def test_same_bytes_by_ordinary_loops(alone):
    assert finished(threads=2, workers=0)[1] == alone[1]


def test_workers_that_no_thread_is_there_for_are_not_waited_for(alone):
    assert finished(threads=1, workers=3)[1] == alone[1]


def test_workers_that_leave_at_once_leave_nothing_undone(alone):
    assert finished(threads=3, patience=0)[1] == alone[1]


def test_spheres_too_on_one_and_four_threads_and_by_ordinary_loops():
    digests = {finished(threads=threads, workers=workers, spheres=True)[1]
               for threads, workers in ((1, None), (4, None), (2, 0))}  # fmt: skip
    assert len(digests) == 1


def test_chunks_hold_every_grain_and_pair_once_and_like_amounts_of_work():
    rng = np.random.default_rng(0)
    position = rng.uniform(0, 0.1, (2, 3000))
    listed = list_neighbours(position[:, np.argsort(position[0])], np.full(3000, 1e-3), 0.3e-3)
    shares = Shares.of(listed, rng.random(listed.pairs.shape[1]) < 0.6, 16)
    for bounds, count in ((shares.grain_bounds, 3000), (shares.pair_bounds, listed.pairs.shape[1])):
        assert bounds[0] == 0 and bounds[-1] == count and bounds.size == 17
        assert (np.diff(bounds) >= 0).all()
    first = np.repeat(np.arange(16), np.diff(shares.grain_bounds))
    chunk = np.repeat(np.arange(16), np.diff(shares.pair_bounds))
    np.testing.assert_array_equal(chunk, first[listed.pairs[0]])
    cost = [
        np.diff(listed.first_contact)[first == one].sum() + np.count_nonzero(first == one)
        for one in range(16)
    ]
    assert max(cost) - min(cost) < 0.02 * sum(cost)


def test_fewer_grains_than_chunks():
    listed = list_neighbours(np.array([[0.0, 1.9e-3], [0.0, 0.0]]), np.full(2, 1e-3), 0.3e-3)
    shares = Shares.of(listed, np.array([True]), 64)
    assert shares.grain_bounds[-1] == 2 and shares.pair_bounds[-1] == 1
