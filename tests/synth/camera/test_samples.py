"""Groups are whole rows of one pixel's samples, in order, in the same memory."""

import numpy as np
import pytest

from synth.camera.samples import in_groups, rows_at_once


@pytest.mark.parametrize("sampling", range(1, 17))
def test_a_group_holds_whole_rows_of_a_pixel(sampling):
    rows = rows_at_once(sampling)
    assert sampling % rows == 0
    samples = np.arange(2 * 3 * sampling**2).reshape(2, 3, sampling, sampling)
    groups = in_groups(samples)
    assert groups.shape == (2, 3, sampling // rows, rows * sampling)
    assert np.shares_memory(groups, samples)
    row = rows if rows < sampling else 0
    assert groups[1, 2, row // rows, 0] == samples[1, 2, row, 0]


def test_common_samplings_have_groups_of_several_rows():
    assert [rows_at_once(sampling) for sampling in (4, 6, 8, 12)] == [4, 6, 4, 3]


def test_taichi_does_not_warn_of_a_loop_over_a_group(taichi):
    longest = max(rows_at_once(sampling) * sampling for sampling in range(1, 17))
    assert 32 < longest <= taichi.lang.impl.get_runtime().unrolling_limit  # 32 is taichi's own limit
