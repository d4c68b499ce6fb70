"""How time steps are taken: by a team of threads that shares each step, or by ordinary parallel loops.

A step has two phases, forces of pairs and motion of grains, and no thread may begin one before all are
through the last. As parallel loops of their own, the phases of ten thousand grains would wait for threads to
be woken longer than they take. So on a CPU one launch takes many steps, and its threads meet by counting.

Every worker has a queue of chunks of neighbouring grains, the same in every step, so that they stay in its
core's cache; who is through with his own helps others. Nobody waits for a worker that has not come, or has
been put aside by the operating system, but for the one chunk that it may have begun; whoever waits too long
even for that leaves his core to it and comes back with the next launch. So the steps are done however many
threads there really are, and there is nothing to wait for in vain.

Import only after `synth.devices.start_taichi`.
"""

from typing import Any, NamedTuple

import taichi as ti

Ref = ti.template()  # an array, or what holds several, handed on to a function

STEPS_AT_ONCE = 64
"""In one launch of a team, at most; `synth.dem.sharing` says how many of so many grains."""
CHUNKS = 32
"""Of a worker's queue, in each phase of a step: one takes some microseconds."""

_TURNS = 512
"""taichi gives a CPU thread no fewer turns of a parallel loop: a worker is the first of so many."""
_LINE = 16
"""Counters in a cache line; each has one of its own."""
_PATIENCE = 2000
"""Looks at a counter, some 50 us in all, before a worker leaves."""


class Team(NamedTuple):
    """Who takes the steps of a launch, and what each has to do; held together while a kernel is compiled.

    Attributes
    ----------
    unrolled : int
        Steps in ordinary loops; 0: steps are shared, and what follows says how.
    grain_count, pair_count : int
    workers, steps : int
        How many.
    grain_bounds, pair_bounds : array of int32, shape (workers * CHUNKS + 1,)
        Where the chunks of grains and of pairs begin and end.
    pair_order : array of int32, shape (pair_count,)
        Which pair after which; a chunk's pairs are its own in any order.
    board : array of int32, shape (board_size(workers),)
        All zero: for each phase, how far each queue and how many chunks are done.
    """

    unrolled: int
    grain_count: Any
    pair_count: Any
    workers: Any
    steps: Any
    grain_bounds: Any
    pair_bounds: Any
    pair_order: Any
    board: Any


def board_size(workers: int) -> int:
    """Counters that a launch of a team needs."""
    return 2 * STEPS_AT_ONCE * (workers + 1) * _LINE


@ti.func
def take_steps(team: Ref, pair_forces: Ref, move_grain: Ref, move_tool: Ref, soil: Ref):
    """All steps of a launch; three functions say what is done. To be called from a kernel's outermost scope.

    The implement takes its step beside the pairs of the next one, which do not ask where it is; after the
    last, it has a task of its own.
    """
    if ti.static(team.unrolled == 0):
        for turn in range(_TURNS * team.workers):
            if turn % _TURNS == 0:
                _work(turn // _TURNS, team, pair_forces, move_grain, move_tool, soil)
    else:
        for step in ti.static(range(team.unrolled)):
            for p in range(team.pair_count + ti.static(int(step > 0))):
                if p < team.pair_count:
                    pair_forces(p, soil)
                else:
                    move_tool(soil)
            for i in range(team.grain_count):
                move_grain(i, soil)
    ti.loop_config(serialize=True)
    for _only in range(1):
        move_tool(soil)


@ti.func
def _work(me, team: Ref, pair_forces: Ref, move_grain: Ref, move_tool: Ref, soil: Ref):
    """What one worker does: phase after phase its own chunks, then those that others have not begun."""
    phase = 0
    while phase < 2 * team.steps:
        counters = phase * (team.workers + 1) * _LINE
        finished = 0
        for ahead in range(team.workers):
            queue = (me + ahead) % team.workers
            chunk = _claimed(team, counters + queue * _LINE, ahead == 0)
            while chunk < CHUNKS:
                c = queue * CHUNKS + chunk
                if phase % 2 == 1:
                    for i in range(team.grain_bounds[c], team.grain_bounds[c + 1]):
                        move_grain(i, soil)
                else:
                    if c == 0 and phase > 0:
                        move_tool(soil)
                    for p in range(team.pair_bounds[c], team.pair_bounds[c + 1]):
                        pair_forces(team.pair_order[p], soil)
                finished += 1
                chunk = _claimed(team, counters + queue * _LINE, True)
        phase += 1
        if not _all_done(team, counters + team.workers * _LINE, finished):
            phase = 2 * team.steps  # leaves; what is left is done by the one waited for


@ti.func
def _claimed(team: Ref, counter, likely):
    """The next chunk of a queue, now the caller's; CHUNKS or more where none is left."""
    chunk = CHUNKS
    # Looking is cheaper than claiming, which takes the counter away from its owner.
    if likely or ti.atomic_add(team.board[counter], 0) < CHUNKS:
        chunk = ti.atomic_add(team.board[counter], 1)
    return chunk


@ti.func
def _all_done(team: Ref, counter, finished):
    """Report finished chunks, then wait for those of others; false where that takes too long."""
    total = team.workers * CHUNKS
    done = ti.atomic_add(team.board[counter], finished) + finished
    looks = 0
    while done < total and looks < _PATIENCE:
        done = ti.atomic_add(team.board[counter], 0)
        looks += 1
    return done >= total
