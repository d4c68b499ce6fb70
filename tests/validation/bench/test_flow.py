"""The flow benchmark tells every method's errors on the same pixels."""

import time

import numpy as np
import pytest

from soft.flow import FlowField, estimate_flow
from validation.bench import flow_measure
from validation.bench.flow import bench_flow
from validation.bench.flow_case import Case, run_cases
from validation.bench.flow_contender import CONTENDERS, Answer, Contender
from validation.bench.flow_measure import measured
from validation.bench.rows import PeerError

NAMED = {contender.name: contender for contender in CONTENDERS}


def still(shape=(40, 60), seed=0):
    picture = np.random.default_rng(seed).integers(0, 255, shape).astype(np.float32)
    return Case("still", picture, picture, np.zeros((*shape, 2)), {"all": np.ones(shape, bool)})


def test_rows_of_a_run(finished_run):
    subjects = [NAMED[name] for name in ("robust-affine", "robust-affine, fast", "DIS, medium")]
    rows = bench_flow(run_cases([finished_run]), subjects=subjects, repeats=1, threads=1)
    told = {(row.subject, row.metric): row.value for row in rows}
    assert {row.subject for row in rows} == {subject.name for subject in subjects}
    for subject in subjects:
        assert told[subject.name, "time"] > 0
        assert 0 < told[subject.name, "all: median error"] < 0.3
        assert 0 <= told[subject.name, "all: wrong by more than 0.3 px"] <= 100
        assert 90 < told[subject.name, "all: measured"] <= 100
    assert told["robust-affine", "all: median error"] < told["DIS, medium", "all: median error"]
    assert 50 < told["robust-affine", "all: errors within the 68 % interval"] <= 100


def test_what_is_not_measured_is_wrong():
    case = still()
    case.first[:, :30] = case.second[:, :30] = 0  # nothing to hold on to
    region = np.zeros((40, 60), bool)
    region[5:-5, 5:15] = region[5:-5, 40:50] = True
    case = Case("half", case.first, case.second, case.truth, {"all": region})
    rows = {row.metric: row.value for row in measured(case, NAMED["Farnebäck"], 1, 1)}
    assert rows["all: wrong by more than 0.3 px"] == pytest.approx(50, abs=1)
    assert rows["all: measured"] == pytest.approx(50, abs=1)


def test_peers_are_asked_for_nothing_that_their_library_does_not_give():
    case = still()
    peers = [contender for contender in CONTENDERS if not contender.own]
    assert {peer.method for peer in peers} == {"dis", "dis-full", "farneback", "ilk", "tvl1"}
    for peer in peers:
        flow = peer.measure(case, 1).flow
        plain = estimate_flow(
            case.first, case.second, method=peer.method, forward_backward=False, **peer.options
        )
        assert flow.uncertainty is None
        assert np.array_equal(flow.displacement, plain.displacement, equal_nan=True)


def test_a_peer_that_is_not_there_is_a_row_that_says_why():
    absent = Contender("absent", "dis", False, package="no-such-distribution")
    (row,) = measured(still(), absent, 5, 1)
    assert (row.value, row.repeats) == (None, 0)
    assert row.version == "no-such-distribution is not installed"
    with pytest.raises(PeerError):
        absent.measure(still(), 1)


class Asked:
    """Says nothing moves, after so many seconds as it was told to claim."""

    def __init__(self, seconds, nodes=None, own=False):
        self.name, self.own, self.seconds, self.nodes, self.count = "asked", own, seconds, nodes, 0

    def measure(self, case, threads):
        self.count += 1
        flow = np.zeros(case.truth.shape)
        return Answer(FlowField(flow, np.ones(flow.shape[:2], bool), nodes=self.nodes), self.seconds, "1")


@pytest.mark.parametrize(
    ("seconds", "own", "runs", "repeats"),
    [(0.1, False, 6, 5), (4.0, False, 4, 3), (11.0, False, 1, 1), (11.0, True, 2, 1)],
)
def test_slow_ones_are_not_repeated(seconds, own, runs, repeats):
    assert flow_measure.LONGEST == 10
    measured(still(), Asked(11.0), 1, 1)  # what is imported on the way does not count below
    asked, began = Asked(seconds, own=own), time.perf_counter()
    row = measured(still(), asked, 5, 1)[0]
    assert (asked.count, row.repeats, row.value) == (runs, repeats, seconds)
    assert time.perf_counter() - began < 5


def test_a_grid_is_judged_at_its_nodes():
    case = still()
    case.truth[..., 0] = np.arange(60) * 0.05  # 0.6 px wrong at x = 12, 2 px at x = 40.2
    nodes = np.full((40, 60, 2), np.nan)
    for x, y in ((4, 10), (12, 10), (40.2, 20)):
        nodes[y, round(x)] = x, y
    rows = {row.metric: row.value for row in measured(case, Asked(0.1, nodes), 1, 1)}
    assert rows["all: measured"] == pytest.approx(100 * 3 / 2400)
    assert rows["all: median error"] == pytest.approx(0.6, abs=1e-6)
    assert rows["all: 95 % error"] == pytest.approx(0.6 + 0.9 * (2.01 - 0.6), abs=1e-5)
    assert rows["all: wrong by more than 0.3 px"] == pytest.approx(100 * 2 / 3)


def test_regions_without_a_node_tell_nothing():
    case = still()
    case = Case("none", case.first, case.second, case.truth, {"far": np.zeros((40, 60), bool)})
    case.regions["far"][5, 5] = True
    nodes = np.full((40, 60, 2), np.nan)
    rows = {row.metric: row.value for row in measured(case, Asked(0.1, nodes), 1, 1)}
    assert rows["far: measured"] == 0
    assert rows["far: median error"] is None and rows["far: wrong by more than 0.3 px"] is None
