"""Whatever cannot be measured is refused in a line, or nothing is said to be measured: by every method."""

import numpy as np
import pytest

from soft.flow import BUILT_IN, FlowError, estimate_flow

ALL = pytest.mark.parametrize("method", sorted(BUILT_IN))
SHAPE = (64, 80)


def noise(shape=SHAPE, seed=0, high=255):
    return np.random.default_rng(seed).uniform(0, high, shape)


@ALL
@pytest.mark.parametrize(
    ("first", "second", "message"),
    [
        (np.where(noise() > 250, np.nan, noise()), noise(), r"first picture: \d+ values are not finite"),
        (noise(), np.where(noise() > 250, np.inf, noise()), r"second picture: \d+ values are not finite"),
        (noise(high=65535).astype(np.uint16), noise(), r"first picture: grey levels .* must lie in 0-255"),
        (noise() - 128, noise(), r"first picture: grey levels -.* must lie in 0-255"),
        (noise((*SHAPE, 3)), noise((*SHAPE, 3)), r"first picture: shape \(64, 80, 3\): must be grey"),
        (noise(), noise((*SHAPE, 3)), r"second picture: shape \(64, 80, 3\): must be grey"),
        (noise(), noise((80, 64)), r"second picture: shape \(80, 64\): the first has \(64, 80\)"),
        (noise((64, 1)), noise((64, 1)), "pictures of 1 x 64 px: .* at least 16"),
        (noise((1, 80)), noise((1, 80)), "pictures of 80 x 1 px: .* at least 16"),
        (noise((0, 80)), noise((0, 80)), "first picture: shape"),
        (noise() > 99, noise(), "first picture: type bool"),
        (noise() * 1j, noise(), "first picture: type complex128"),
        (None, noise(), "first picture: shape"),
    ],
)
def test_refused(method, first, second, message):
    with pytest.raises(FlowError, match=message) as refused:
        estimate_flow(first, second, method=method)
    assert "\n" not in str(refused.value)


@ALL
@pytest.mark.parametrize("level", [0, 99, 255])
def test_constant_pictures_measure_nothing(method, level):
    picture = np.full(SHAPE, level, np.uint8)
    assert_nothing(estimate_flow(picture, picture, method=method))


@ALL
def test_a_constant_first_picture_measures_nothing(method):
    assert_nothing(estimate_flow(np.full(SHAPE, 40.0), noise(), method=method))


@ALL
def test_a_constant_second_picture_measures_nothing(method):
    assert_nothing(estimate_flow(noise(), np.full(SHAPE, 40.0), method=method))


@ALL
def test_nothing_to_use_measures_nothing(method):
    field = estimate_flow(noise(), noise(), method=method, mask=np.zeros(SHAPE, bool))
    assert_nothing(field)


@ALL
def test_a_single_pixel_to_use_does_not_fail(method):
    mask = np.zeros(SHAPE, bool)
    mask[30, 40] = True
    field = estimate_flow(noise(), noise(), method=method, mask=mask)
    assert field.valid.sum() <= 1 and not field.valid[~mask].any()


@ALL
def test_unlike_pictures_are_hardly_valid(method):
    """Two pictures that have nothing in common: most of what is found one way is not found back."""
    first, second = (noise((96, 128), seed) for seed in (1, 2))
    checked = estimate_flow(first, second, method=method, forward_backward=0.5)
    assert checked.valid.mean() < 0.8


def assert_nothing(field):
    assert not field.valid.any()
    assert np.isnan(field.displacement).all()
    assert field.uncertainty is None or np.isnan(field.uncertainty).all()
