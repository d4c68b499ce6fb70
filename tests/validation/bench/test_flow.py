"""The flow benchmark tells every method's errors on the same pixels."""

import numpy as np
import pytest

from validation.bench.flow import bench_flow
from validation.bench.flow_case import Case, run_cases
from validation.bench.flow_contender import CONTENDERS
from validation.bench.flow_measure import measured


def test_rows_of_a_run(finished_run):
    rows = bench_flow(run_cases([finished_run]), contenders=CONTENDERS[:3], repeats=1, threads=1)
    told = {(row.subject, row.metric): row.value for row in rows}
    assert {row.subject for row in rows} == {contender.name for contender in CONTENDERS[:3]}
    for contender in CONTENDERS[:3]:
        assert told[contender.name, "time"] > 0
        assert 0 < told[contender.name, "all: median error"] < 0.3
        assert 0 <= told[contender.name, "all: wrong by more than 0.3 px"] <= 100
    assert told["robust-affine", "all: median error"] < told["DIS, medium", "all: median error"]
    assert 50 < told["robust-affine", "all: errors within the 68 % interval"] <= 100


def test_what_is_not_measured_is_wrong():
    picture = np.zeros((40, 60), np.uint8)  # nothing to hold on to
    picture[:, 30:] = np.random.default_rng(0).integers(0, 255, (40, 30))
    region = np.zeros((40, 60), bool)
    region[5:-5, 5:15] = region[5:-5, 40:50] = True
    case = Case("half", picture, picture, np.zeros((40, 60, 2)), {"all": region})
    rows = {row.metric: row.value for row in measured(case, CONTENDERS[4], 1, 1)}
    assert rows["all: wrong by more than 0.3 px"] == pytest.approx(50, abs=1)
