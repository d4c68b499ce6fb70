"""Errors sorted by what may explain them, against fields whose answer is known."""

import numpy as np
import pytest
import xarray as xr

from validation.scoring.error_profile import (
    CAUSES,
    ERROR_EDGES,
    EXPLANATIONS,
    MOMENTS,
    error_profile,
    percentile,
)
from validation.scoring.strata import find_strata
from validation.scoring.truth_pass import TruePair

SHAPE = (40, 60)


@pytest.fixture
def truth(make_truth):
    """Soil that moves 2 px to the right, an implement at the left, shear that grows to the right."""
    x = np.broadcast_to(np.arange(SHAPE[1], dtype=np.float32), SHAPE)
    zero = np.zeros(SHAPE, np.float32)
    return make_truth(
        np.full(SHAPE, 2.0),
        0.0,
        distance_to_implement=x,
        distance_to_discontinuity=np.full(SHAPE, np.inf, np.float32),
        discontinuity_jump=np.full(SHAPE, np.nan, np.float32),
        strain_rate=x / 100,
        rotation=zero,
        camera_u=0.0,
    )


def flow(u, v=0.0):
    field = np.broadcast_to(np.float32(u), SHAPE), np.broadcast_to(np.float32(v), SHAPE)
    return xr.Dataset({name: (("y", "x"), one.copy()) for name, one in zip("uv", field, strict=True)})


def test_every_pixel_is_in_one_bin(truth):
    profile = error_profile(TruePair(truth), flow(2.1))
    for name in ("distance_to_implement", "distance_to_discontinuity", "strain_rate", "rotation", "speed"):
        assert profile[f"count_{name}"].sum() == SHAPE[0] * SHAPE[1], name
    assert profile["count_discontinuity_jump"].sum() == 0


def test_distances(truth):
    counts = error_profile(TruePair(truth), flow(2.1))["count_distance_to_implement"].sum("error_bin").values
    assert counts[:4].tolist() == [40, 40, 40, 80]  # 0-1, 1-2, 2-3, 3-5 px: columns of 40 px
    assert (
        error_profile(TruePair(truth), flow(2.1))["count_distance_to_discontinuity"]
        .sum("error_bin")
        .values[-1]
        == 2400
    )


def test_error_at_the_implement_alone(truth):
    u = np.full(SHAPE, 2.0)
    u[:, :2] += 0.5
    histogram = error_profile(TruePair(truth), flow(u))["count_distance_to_implement"].values
    median = percentile(histogram, 0.5)
    assert median[:2] == pytest.approx([0.5, 0.5], rel=0.05)
    assert (median[2:7] < 0.004).all()


def test_bias_along_and_across(truth):
    profile = error_profile(TruePair(truth), flow(2.3, 0.1))
    number, along, across, along2, _ = profile["sums_speed"].sum("bin_speed").values
    assert MOMENTS[0] == "number" and number == 2400
    assert along / number == pytest.approx(0.3, abs=1e-6)
    assert across / number == pytest.approx(0.1, abs=1e-6)
    assert along2 / number - (along / number) ** 2 == pytest.approx(0, abs=1e-6)  # no random error


def test_unmeasured(truth):
    u = np.full(SHAPE, 2.0)
    u[:, 0] = np.nan
    profile = error_profile(TruePair(truth), flow(u))
    assert profile["unmeasured_distance_to_implement"].values[:2].tolist() == [40, 0]
    assert profile["count_distance_to_implement"].values[0].sum() == 0


def test_profiles_add_up(truth):
    one = error_profile(TruePair(truth), flow(2.1))
    assert (one + one)["count_speed"].sum() == 2 * one["count_speed"].sum()


def test_percentile_of_known_errors():
    errors = np.random.default_rng(0).lognormal(-2, 1, 100_000)
    histogram = np.histogram(errors, ERROR_EDGES)[0]
    for share in (0.1, 0.5, 0.95):
        assert percentile(histogram, share) == pytest.approx(np.quantile(errors, share), rel=0.01)
    assert np.isnan(percentile(np.zeros(len(ERROR_EDGES) - 1), 0.5))


def test_edges_rise():
    for name, explanation in EXPLANATIONS.items():
        assert (np.diff(explanation.edges) > 0).all() and np.isinf(explanation.edges[-1]), name


def test_every_cause_is_in_the_stratum_it_is_of(truth):
    u = truth["u"].values.copy()
    u[:, 40:] = 0.0  # a step at the 40th column
    distance = np.abs(np.arange(SHAPE[1], dtype=np.float32) - 39.5)
    split = truth.assign(
        u=(truth["u"].dims, u),
        distance_to_discontinuity=(truth["u"].dims, np.broadcast_to(distance, SHAPE)),
        strain_rate=(truth["u"].dims, np.zeros(SHAPE, np.float32)),
    )
    found = error_profile(TruePair(split), flow(2.0))["count_cause"].sum("error_bin").values
    told = dict(zip(CAUSES, found.tolist(), strict=True))
    masks = find_strata(split).masks
    assert told["at the implement"] == 4 * SHAPE[0]  # 0 to 3 px
    assert told["at a discontinuity"] == 6 * SHAPE[0]
    assert told["quiet"] == masks["quiet"].sum()
    assert sum(found[:6]) == masks["complex"].sum() and found.sum() == masks["all"].sum()
