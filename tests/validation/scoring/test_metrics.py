import numpy as np
import pytest

from validation.scoring.metrics import ErrorTally


def summary_of(*parts):
    tally = ErrorTally()
    for u, v in parts:
        tally.add(np.asarray(u, float), np.asarray(v, float))
    return ErrorTally.summary([tally])


def test_a_constant_error():
    summary = summary_of((np.full(1000, 0.3), np.full(1000, -0.4)))
    assert summary.pixel_count == 1000
    assert summary.coverage == 1
    for value in (summary.median, summary.mean, summary.p95, summary.rmse):
        assert value == pytest.approx(0.5, abs=1e-7)
    assert (summary.bias_u, summary.bias_v) == (pytest.approx(0.3), pytest.approx(-0.4))
    assert summary.wrong_share == {"0.3": 1.0, "0.56": 0.0, "1.0": 0.0}


def test_percentiles_are_exact_over_pairs():
    error = np.random.default_rng(1).permutation(np.arange(1001) / 1000)
    summary = summary_of(*((part, np.zeros(part.size)) for part in np.array_split(error, 7)))
    assert summary.median == pytest.approx(0.5, abs=1e-7)
    assert summary.p95 == pytest.approx(0.95, abs=1e-7)
    assert summary.mean == pytest.approx(0.5)
    assert summary.rmse == pytest.approx(np.sqrt(np.mean(error**2)))
    assert summary.wrong_share["0.3"] == pytest.approx(700 / 1001)


def test_gaussian_noise_follows_rayleigh():
    u, v = np.random.default_rng(0).normal(0, 0.2, (2, 400_000))
    summary = summary_of((u, v))
    assert summary.median == pytest.approx(0.2 * np.sqrt(2 * np.log(2)), rel=0.01)
    assert summary.p95 == pytest.approx(0.2 * np.sqrt(2 * np.log(20)), rel=0.01)
    assert summary.rmse == pytest.approx(0.2 * np.sqrt(2), rel=0.01)
    assert summary.bias_u == pytest.approx(0, abs=2e-3)


def test_what_was_not_measured_is_wrong():
    u = np.array([0.0, 0.0, 0.0, np.nan])
    summary = summary_of((u, np.zeros(4)))
    assert summary.coverage == 0.75
    assert summary.median == 0
    assert summary.wrong_share == {"0.3": 0.25, "0.56": 0.25, "1.0": 0.25}


def test_nothing_measured():
    summary = summary_of((np.full(4, np.nan), np.zeros(4)))
    assert (summary.pixel_count, summary.coverage, summary.median, summary.bias_u) == (4, 0.0, None, None)
    assert summary.wrong_share["1.0"] == 1.0


def test_an_empty_stratum():
    for summary in (ErrorTally.summary([]), summary_of(([], []))):
        assert summary.pixel_count == 0
        values = summary.to_dict()
        assert values.pop("pixel_count") == 0
        assert values.pop("wrong_share") == {"0.3": None, "0.56": None, "1.0": None}
        assert set(values.values()) == {None}


def test_union_of_sets():
    low, high = ErrorTally(), ErrorTally()
    low.add(np.full(3, 0.1), np.zeros(3))
    high.add(np.full(1, 2.0), np.zeros(1))
    summary = ErrorTally.summary([low, high])
    assert summary.pixel_count == 4
    assert summary.mean == pytest.approx(2.3 / 4)
    assert summary.wrong_share["1.0"] == 0.25
