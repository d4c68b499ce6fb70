"""The law beside a real single-wheel rig; skipped where its data are not at hand."""

import os
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from validation.cli import run_command
from validation.identification.wheel_rig import RigError, compare_with_rig, read_trials

DATA = Path(os.environ.get("SOFTBED_DATA", "nowhere")) / "wheel_rig" / "smooth_wheel.mat"
with_data = pytest.mark.skipif(not DATA.is_file(), reason="$SOFTBED_DATA/wheel_rig is not at hand")


@pytest.fixture(scope="module")
def comparison():
    return compare_with_rig(read_trials(DATA))


@with_data
def test_slip_is_of_the_measured_rim_speed():
    trials = read_trials(DATA)
    slips = [one.slip for one in trials]
    np.testing.assert_allclose(slips, [-1, -0.7, -0.5, -0.2, 0, 0.23, 0.5, 0.75, 0.9], atol=0.005)
    assert slips[0] == -1
    assert trials[4].sinkage == pytest.approx(0.0144, abs=2e-4)
    assert trials[4].drawbar_pull == pytest.approx(-1.34, abs=0.05)


@with_data
def test_the_law_holds_for_the_driven_half_that_it_is_fitted_to(comparison):
    driven = [k for k in range(9) if not comparison.is_braked(k)]
    assert len(driven) == 5
    for k in driven:
        one, law = comparison.measured[k], comparison.predicted[k]
        assert law.sinkage == pytest.approx(one.sinkage, rel=0.2)
        assert law.drawbar_pull == pytest.approx(one.drawbar_pull, abs=0.05 * one.load)


@with_data
def test_published_constants_alone_come_near_it(comparison):
    for k in range(4, 9):
        one, law = comparison.measured[k], comparison.unfitted[k]
        assert law.sinkage == pytest.approx(one.sinkage, rel=0.25)
        assert law.drawbar_pull == pytest.approx(one.drawbar_pull, abs=0.11 * one.load)


@with_data
def test_a_slightly_braked_wheel_is_predicted_and_a_locked_one_is_not(comparison):
    slightly, locked = comparison.measured[3], comparison.measured[0]
    assert comparison.predicted[3].drawbar_pull == pytest.approx(slightly.drawbar_pull, rel=0.15)
    assert comparison.predicted[3].sinkage == pytest.approx(slightly.sinkage, rel=0.15)
    assert comparison.predicted[0].drawbar_pull > 0.6 * locked.drawbar_pull


@with_data
def test_a_braked_wheel_is_held_back_as_predicted_at_its_own_sinkage_but_borne_too_well(comparison):
    """What the law lacks where wheels slide is how deep they sink, not drag."""
    for k in (1, 2, 3):
        assert comparison.at_sinkage[k].force_x == pytest.approx(comparison.measured[k].drawbar_pull, rel=0.1)
    assert comparison.at_sinkage[0].force_x == pytest.approx(comparison.measured[0].drawbar_pull, rel=0.3)
    for k in (0, 1):
        assert comparison.at_sinkage[k].force_z > 1.4 * comparison.measured[k].load


def test_another_file_is_refused(tmp_path):
    with pytest.raises(RigError, match="a MATLAB file with the struct array 'all_results' is needed"):
        (tmp_path / "a.mat").write_bytes(b"not one")
        read_trials(tmp_path / "a.mat")
    savemat(tmp_path / "b.mat", {"other": 1})
    with pytest.raises(RigError, match="'all_results' is needed"):
        read_trials(tmp_path / "b.mat")


def test_a_file_that_is_not_there_is_told(tmp_path, capfd):
    missing = tmp_path / "none.mat"
    assert run_command(["identify", str(tmp_path / "out"), "--rig", str(missing)]) == 2
    assert capfd.readouterr().err == f"softbed: {missing}: no such file\n"
    assert not (tmp_path / "out").exists()
