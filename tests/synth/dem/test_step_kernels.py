"""Steps shared among threads: the same bytes however many there are, and whenever they come or leave."""

import functools
import json
import subprocess
import sys

import numpy as np
import pytest

from synth.dem.neighbours import list_neighbours
from synth.dem.sharing import Shares

PROGRAM = """
import hashlib, json, sys
from dataclasses import replace
import numpy as np
from synth.devices import start_taichi

threads, patience, cases = json.loads(sys.argv[1])
start_taichi(threads=threads)
from synth.dem import step_kernels
step_kernels._PATIENCE = patience
from synth.dem.contact_law import ContactLaw
from synth.dem.grains import Grains, Spheres
from synth.dem.solver import Solver
from synth.dem.tool import Tool
from synth.implements import Shape


def solver_of(spheres):
    rng = np.random.default_rng(4)
    stiffness = 1e3 if spheres else 1e6
    law = ContactLaw(stiffness, stiffness / 2, 0.2, 0.4, 0.3, 0.3, 0.1)
    i, j = (one.ravel() for one in np.meshgrid(np.arange(40), np.arange(15)))
    place = np.stack([i, j]) + 0.6 + 0.2 * rng.uniform(size=(2, i.size))
    radius = 1e-3 * rng.uniform(0.8, 1.2, i.size)
    if spheres:
        place = np.stack([place[0], 0.9 + 0.2 * rng.uniform(size=i.size), place[1]])
    kind = Spheres if spheres else Grains
    grains = kind.at_rest(2.1e-3 * place, radius, 2000.0)
    grains = replace(grains, velocity=rng.normal(0, 0.2, grains.position.shape))
    wheel = Tool(Shape.disc(0.02), x=0.04, z=0.0535, velocity_z=-2.0, spin=-20.0)
    slab = {"thickness": 5e-3} if spheres else {}
    return Solver(grains, law, 0.09, 2e-6, tool=wheel, **slab)


def digest_of(solver, workers):
    if workers is not None:
        solver._workers = workers
    solver._board = solver._array(np.zeros(step_kernels.board_size(solver._workers), np.int32))
    solver._put_lists_on_device()
    solver.advance(501)
    end, impulse = solver.read_grains(), solver.take_tool_impulse()
    force = np.array([impulse.x, impulse.z, impulse.moment])
    assert impulse.z != 0
    values = (end.position, end.velocity, end.angle, end.spin, force)
    return hashlib.sha256(b"".join(value.tobytes() for value in values)).hexdigest()


found = []
for spheres, workers in cases:
    solver = solver_of(spheres)
    digest = digest_of(solver, workers)
    found.append((solver._workers, digest))
print(json.dumps(found))
"""
DISCS, SPHERES, PATIENCE = False, True, 2000
AS_MANY_AS_THREADS, NONE_BUT_ORDINARY_LOOPS = None, 0
CASES = {
    (1, PATIENCE): [(DISCS, AS_MANY_AS_THREADS), (DISCS, 3), (SPHERES, AS_MANY_AS_THREADS)],
    (2, PATIENCE): [
        (DISCS, AS_MANY_AS_THREADS), (DISCS, NONE_BUT_ORDINARY_LOOPS), (SPHERES, NONE_BUT_ORDINARY_LOOPS),
    ],
    (4, PATIENCE): [(DISCS, AS_MANY_AS_THREADS), (SPHERES, AS_MANY_AS_THREADS)],
    (3, 0): [(DISCS, AS_MANY_AS_THREADS)],
}  # fmt: skip
"""What is stepped, and by how many workers, in the process that has so many threads and such patience."""


@functools.cache
def outcomes(threads, patience):
    """Workers there were and the digest of what came out, by case; one process makes and compiles for all."""
    cases = CASES[threads, patience]
    told = json.dumps([threads, patience, cases])
    done = subprocess.run([sys.executable, "-c", PROGRAM, told], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout.splitlines()[-1])
    return dict(zip(cases, map(tuple, found), strict=True))


def outcome(threads, *, workers=AS_MANY_AS_THREADS, patience=PATIENCE, kind=DISCS):
    return outcomes(threads, patience)[kind, workers]


@pytest.mark.parametrize("threads", [2, 4])
def test_same_bytes_on_any_number_of_threads_also_beyond_the_cores(threads):
    alone = outcome(1)
    assert alone[0] == 1
    assert outcome(threads) == (threads, alone[1])


def test_same_bytes_by_ordinary_loops():
    assert outcome(2, workers=NONE_BUT_ORDINARY_LOOPS) == (0, outcome(1)[1])


def test_workers_that_no_thread_is_there_for_are_not_waited_for():
    assert outcome(1, workers=3) == (3, outcome(1)[1])


def test_workers_that_leave_at_once_leave_nothing_undone():
    assert outcome(3, patience=0) == (3, outcome(1)[1])


def test_spheres_too_on_one_and_four_threads_and_by_ordinary_loops():
    found = outcome(1, kind=SPHERES), outcome(4, kind=SPHERES)
    by_loops = outcome(2, workers=NONE_BUT_ORDINARY_LOOPS, kind=SPHERES)
    assert [workers for workers, _ in (*found, by_loops)] == [1, 4, 0]
    assert len({digest for _, digest in (*found, by_loops)}) == 1
    assert found[0][1] != outcome(1)[1]


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
