"""Items of a parallel loop are dealt once each, and to every thread from everywhere."""

import numpy as np
import pytest
import taichi as ti

from synth.camera.share_kernels import dealt_to


def dealt_items(count, together, hands):
    """Items of the turns 0, 1, ... in a deal."""
    items = np.full(count, -1, np.int32)

    @ti.kernel
    def deal(items: ti.types.ndarray(dtype=ti.i32, ndim=1)):
        for turn in range(items.shape[0]):
            items[turn] = dealt_to(turn, items.shape[0], together, hands)

    deal(items)
    return items


@pytest.mark.parametrize(
    ("count", "together", "hands"),
    [(600, 32, 2), (601, 1, 2), (7, 4, 2), (100, 3, 5), (1, 1, 16), (64, 8, 1)],
)
def test_every_item_has_one_turn(taichi, count, together, hands):
    np.testing.assert_array_equal(np.sort(dealt_items(count, together, hands)), np.arange(count))


def test_a_hand_gets_runs_of_neighbours_from_everywhere(taichi):
    items = dealt_items(24, 3, 2)
    np.testing.assert_array_equal(items[:12], [0, 1, 2, 6, 7, 8, 12, 13, 14, 18, 19, 20])
    np.testing.assert_array_equal(items[12:], items[:12] + 3)


def test_what_is_left_comes_last(taichi):
    np.testing.assert_array_equal(dealt_items(10, 2, 2)[8:], [8, 9])
