"""OpenPIV, where SOFTBED_OPENPIV names an interpreter with it, and what is said where it is not."""

import os
import sys

import numpy as np
import pytest

from validation.bench.flow_case import Case
from validation.bench.flow_measure import measured
from validation.bench.openpiv import OpenPiv
from validation.bench.rows import PeerError
from validation.scoring.nodes import difference_at, truth_at


@pytest.fixture(scope="module")
def turned():
    """Plane waves turned by 0.02 rad and moved by (3, -2) px."""
    rng = np.random.default_rng(5)
    angle, phase = rng.uniform(0, 2 * np.pi, (2, 200))
    number = 2 * np.pi / rng.uniform(5, 20, 200)

    def texture(x, y):
        waves = (
            np.cos(k * (np.cos(a) * x + np.sin(a) * y) + p)
            for k, a, p in zip(number, angle, phase, strict=True)
        )
        return np.clip(128 + 4 * sum(waves), 0, 255).astype(np.float32)

    y, x = np.mgrid[:313, :448].astype(float)
    places, centre, shift = np.stack([x, y], axis=-1), np.array([223.5, 156.0]), np.array([3.0, -2.0])
    turn = np.array([[np.cos(0.02), -np.sin(0.02)], [np.sin(0.02), np.cos(0.02)]])
    before = (places - centre - shift) @ turn + centre
    truth = (places - centre) @ turn.T + centre + shift - places
    inner = np.zeros(x.shape, bool)
    inner[48:-48, 48:-48] = True
    return Case("turned", texture(x, y), texture(before[..., 0], before[..., 1]), truth, {"all": inner})


def test_where_it_is_not_a_row_says_why(turned):
    (row,) = measured(turned, OpenPiv(None), 5, 1)
    assert row.value is None and "--openpiv PYTHON" in row.version and not row.own
    (row,) = measured(turned, OpenPiv("/nowhere/python"), 5, 1)
    assert row.value is None and "/nowhere/python" in row.version
    with pytest.raises(PeerError, match="No module named 'openpiv'"):
        OpenPiv(sys.executable).measure(turned, 1)


@pytest.mark.skipif(not os.environ.get("SOFTBED_OPENPIV"), reason="SOFTBED_OPENPIV names no interpreter")
def test_conventions(turned):
    """Taken for forward vectors, or a px aside, they would be more than twice as wrong."""
    answer = OpenPiv(os.environ["SOFTBED_OPENPIV"]).measure(turned, 1)
    flow, region = answer.flow, turned.regions["all"]

    def error(nodes):
        difference = difference_at(flow.displacement, turned.truth, nodes)
        return float(np.nanmedian(np.hypot(difference[..., 0], difference[..., 1])[region]))

    assert answer.seconds > 0 and answer.version[0].isdigit()
    assert (region & flow.valid).sum() > 200
    right = error(flow.nodes)
    assert right < 0.02
    shifted = np.roll(turned.truth, (1, 1), (0, 1))
    off = np.hypot(*np.moveaxis(difference_at(flow.displacement, shifted, flow.nodes), -1, 0))[region]
    assert np.nanmedian(off) > 1.5 * right
    at_middle = flow.nodes + flow.displacement / 2
    rows, columns = np.nonzero(flow.valid & region)
    places = at_middle[rows, columns].astype(float)
    naive = flow.displacement[rows, columns] - truth_at(turned.truth, places)
    assert np.median(np.hypot(*naive.T)) > 2 * right
