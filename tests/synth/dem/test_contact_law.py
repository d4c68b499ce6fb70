import numpy as np
import pytest

from synth.dem.contact_law import contact_time, damping_ratio_of, largest_time_step, restitution_of


@pytest.mark.parametrize("restitution", [0.15, 0.3, 0.5, 0.9, 0.999])
def test_damping_ratio_inverts_restitution(restitution):
    assert restitution_of(damping_ratio_of(restitution)) == pytest.approx(restitution, rel=1e-9)


def test_elastic_contact_has_no_damping():
    assert damping_ratio_of(1.0) == 0.0


def test_critical_damping_still_rebounds_because_nothing_pulls():
    assert restitution_of(1 - 1e-9) == pytest.approx(np.exp(-2), rel=1e-4)


@pytest.mark.parametrize("restitution", [0.0, 0.1, 1.01, -0.5])
def test_impossible_restitution_is_refused(restitution):
    with pytest.raises(ValueError, match=r"restitution = .* allowed"):
        damping_ratio_of(restitution)


def test_time_step_resolves_the_lightest_grain():
    masses = np.array([4.0, 1.0, 9.0])
    assert largest_time_step(masses, 100.0, 20) == pytest.approx(np.pi * np.sqrt(0.5 / 100) / 20)
    assert contact_time(1.0, 100.0) == pytest.approx(np.pi * np.sqrt(0.5 / 100))
