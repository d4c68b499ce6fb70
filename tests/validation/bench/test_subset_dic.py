"""pyvale, where SOFTBED_PYVALE names an interpreter with it, and what is said where it is not."""

import os
import sys

import numpy as np
import pytest

from synth import picture_pair
from validation.bench.flow_case import Case
from validation.bench.flow_measure import measured
from validation.bench.rows import PeerError
from validation.bench.subset_dic import SubsetDic


@pytest.fixture(scope="module")
def turned():
    pair = picture_pair("sand_rotation", quick=True, seed=5)
    first, second = pair.first.astype(np.float32), pair.second.astype(np.float32)
    return Case("turned", first, second, pair.displacement, {"all": pair.valid})


def test_where_it_is_not_a_row_says_why(turned):
    (row,) = measured(turned, SubsetDic(None), 5, 1)
    assert row.value is None and "--pyvale PYTHON" in row.version and not row.own
    with pytest.raises(PeerError, match="No module named 'pyvale'"):
        SubsetDic(sys.executable).measure(turned, 1)


@pytest.mark.skipif(not os.environ.get("SOFTBED_PYVALE"), reason="SOFTBED_PYVALE names no interpreter")
def test_conventions(turned):
    """Half a px aside, vectors of this rotation would be 0.015 px off."""
    rows = measured(turned, SubsetDic(os.environ["SOFTBED_PYVALE"]), 1, 1)
    told = {row.metric: row.value for row in rows}
    assert told["all: median error"] < 0.008
    assert rows[0].version[0].isdigit()
