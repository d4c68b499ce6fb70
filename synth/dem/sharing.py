"""Who takes the time steps: how many threads, and which grains and pairs are whose."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from synth.dem.neighbours import NeighbourList

_GRAINS_A_WORKER = 128
"""At least: fewer are sooner done by one than two have met."""
_GRAIN_STEPS = 400_000
"""Grains x steps of a launch, some 10 ms of two cores: so long may one worker be alone where others left."""


@dataclass(frozen=True)
class Shares:
    """Chunks of a team's work: contiguous, with about as many pairs in each.

    A pair is in the chunk of its first grain, so that who computed a force mostly finds it in his own cache.
    Of a chunk, pairs that touch come first: whether the next one touches is then no surprise to a processor.

    Attributes
    ----------
    grain_bounds, pair_bounds : ndarray of int32, shape (chunks + 1,)
        Where the chunks begin and end.
    pair_order : ndarray of int32, shape (P,)
        Pairs of the list, chunk by chunk.
    """

    grain_bounds: np.ndarray
    pair_bounds: np.ndarray
    pair_order: np.ndarray

    @classmethod
    def of(cls, neighbours: NeighbourList, touching: np.ndarray, chunks: int) -> "Shares":
        """Grains and pairs of a list cut into so many chunks; `touching` is a mask of the pairs, (P,)."""
        ends = neighbours.first_contact  # a grain's contacts, and itself, are what it costs
        cost = ends + np.arange(ends.size)
        wanted = cost[-1] * np.arange(1, chunks) / chunks
        inner = np.searchsorted(cost, wanted)
        grain_bounds = np.concatenate([[0], inner, [ends.size - 1]]).astype(np.int32)
        pair_bounds = np.searchsorted(neighbours.pairs[0], grain_bounds).astype(np.int32)
        chunk = np.repeat(np.arange(chunks, dtype=np.int32), np.diff(pair_bounds))
        pair_order = np.argsort(2 * chunk + ~touching, kind="stable").astype(np.int32)
        return cls(grain_bounds, pair_bounds, pair_order)


def worker_count(ti: Any, grain_count: int) -> int:
    """Threads that share the steps of so many grains; 0: ordinary loops, where there is no CPU to share."""
    config = ti.lang.impl.current_cfg()
    if config.arch not in (ti.x64, ti.arm64):
        return 0
    return max(1, min(config.cpu_max_num_threads, grain_count // _GRAINS_A_WORKER))


def steps_at_once(grain_count: int) -> int:
    """Steps that a team takes of so many grains in one launch, at most."""
    from synth.dem.step_kernels import STEPS_AT_ONCE

    return min(STEPS_AT_ONCE, max(1, _GRAIN_STEPS // grain_count))
