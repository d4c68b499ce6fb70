import numpy as np
import pytest

from validation.calibration.search import OutOfReachError, search


def run(value_at, target, **options):
    tried = []

    def watched(place):
        tried.append(place)
        return value_at(place)

    defaults = {"low": 0.0, "high": 1.0, "resolution": 0.01, "tolerance": 0.005}
    return search(watched, target, **(defaults | options)), tried


@pytest.mark.parametrize("target", [0.1, 0.37, 0.5, 0.9])
@pytest.mark.parametrize("shape", [np.sqrt, np.square, np.sin, lambda x: np.tanh(8 * x)])
def test_finds_where_a_rising_function_meets_the_target(shape, target):
    target = target * shape(1.0)
    found, tried = run(shape, target)
    best = min(np.arange(0, 1.001, 0.01), key=lambda place: abs(shape(place) - target))
    assert abs(shape(found) - target) <= max(0.005, abs(shape(best) - target))
    assert len(tried) <= 10
    assert len(set(tried)) == len(tried)


def test_places_are_multiples_of_the_resolution():
    _, tried = run(np.sqrt, 0.6, resolution=0.05)
    np.testing.assert_allclose(np.array(tried) / 0.05, np.round(np.array(tried) / 0.05), atol=1e-9)


def test_noise_does_not_keep_it_from_ending():
    noise = np.random.default_rng(1).normal(0, 0.03, 101)
    found, tried = run(lambda x: np.sqrt(x) + noise[round(100 * x)], 0.6)
    assert found == pytest.approx(0.36, abs=0.1)
    assert len(tried) <= 20


@pytest.mark.parametrize("target", [0.1, 0.9])
def test_what_is_out_of_reach_is_said(target):
    with pytest.raises(OutOfReachError, match=r"within reach is 0\.2 to 0\.8"):
        run(lambda x: 0.2 + 0.6 * x, target)


def test_an_end_that_is_good_enough_is_taken():
    assert run(lambda x: 0.2 + 0.6 * x, 0.802)[0] == 1.0
