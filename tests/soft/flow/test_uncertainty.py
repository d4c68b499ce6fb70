"""How sure `robust-affine` says it is: what each part of its uncertainty answers to."""

import numpy as np
import pytest

from soft.flow.robust_affine.rim import carried_outwards, carry_outwards
from soft.flow.robust_affine.uncertainty import FACTORS, standard_deviation, widen_at_rim
from soft.flow.robust_affine.windows import Chosen

SHAPE = (60, 80)
SIZES = (2.5, 4.0, 7.0, 12.0, 20.0)


def chosen(level, *, wave=0.0, excess=0.0):
    """Windows of one size, noise of 0.01 px each; the gradient of u along x goes in waves of 40 px."""
    models = np.zeros((*SHAPE, 6), np.float32)
    models[:, :, 1] = 0.02 + wave * np.sin(2 * np.pi * np.arange(SHAPE[1]) / 20)
    pairs = (*SHAPE, 2)
    return Chosen(
        models,
        np.full(pairs, 1e-4, np.float32),
        np.full(SHAPE, level, np.int32),
        np.full(pairs, excess, np.float32),
        np.zeros(SHAPE, np.float32),
        2,
        SIZES,
    )


def middle(of, *, stretch=1.0, mended=0.0):
    models = of.models.copy()
    models[:, :, ::3] += mended
    return float(standard_deviation(of, models, "accurate", stretch)[30, 40, 0])


@pytest.mark.parametrize("level", range(len(SIZES)))
def test_where_motion_bends_noise_hides_more(level):
    even, bent = middle(chosen(level)), middle(chosen(level, wave=0.2))
    assert even < 0.6 * bent  # a uniform strain does not count
    assert even > 0.003 and bent < 0.03


def test_noisy_slopes_excess_and_mending_count_where_their_factors_say():
    for level in range(len(SIZES)):
        here = chosen(level, wave=0.02)
        factors, least = FACTORS["accurate"], middle(here)
        for more, factor, unit in (
            (middle(here, stretch=1.5), factors.stretched, 0.5e-4),
            (middle(chosen(level, wave=0.02, excess=3e-4)), factors.excess, 3e-4),
            (middle(here, mended=0.02), factors.mended, 4e-4),
        ):
            assert more**2 - least**2 == pytest.approx(factor[level] * unit, rel=1e-2, abs=1e-8)


def test_sigma_is_larger_at_the_rim_alone():
    mask = np.ones(SHAPE, bool)
    mask[:, :10] = False
    sigma = widen_at_rim(np.ones((*SHAPE, 2)), mask)
    assert (sigma[:, 10:15] > 1.5).all() and (sigma[:, 15:] == 1).all() and (sigma[:, :10] == 1).all()


def test_fields_are_carried_outwards_as_models_are():
    random = np.random.default_rng(3)
    models = random.normal(0, 1, (*SHAPE, 6)).astype(np.float32)
    mask = random.uniform(size=SHAPE) < 0.9
    usable = mask.copy()
    usable[:, :12] = usable[40:45] = False
    displacement, gradient = models[:, :, ::3].copy(), models[:, :, [1, 2, 4, 5]].copy()
    carry_outwards(displacement, gradient, usable, mask)
    carried = carried_outwards(models, usable, mask)
    assert (carried != models).any()
    assert np.array_equal(displacement, carried[:, :, ::3])
    assert np.array_equal(gradient, carried[:, :, [1, 2, 4, 5]])
