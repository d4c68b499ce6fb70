import numpy as np
import pytest

from synth.rover.law.identification import Trial, identify, misfits, predict
from synth.rover.law.interface import PlacedWheel
from synth.rover.law.response import SoilError
from synth.rover.law.rft import ResistiveForceLaw, ResistiveSoil
from synth.rover.law.single_wheel import Paths, lead
from synth.scene import load_scene

SOIL = ResistiveSoil(
    scale=2.5e6, surface_friction=0.4, stiffness=1.25e7, shear_share=0.1, rut_share=0.5, damping_time=0.0
)


def trials():
    return [Trial(slip, load, 0.114, 0.057) for load in (20.0, 40.0) for slip in (0.0, 0.2, 0.6)]


def test_wheels_follow_their_loads():
    wheels = [PlacedWheel(f"{k}", f"{k}", 0.114, 0.057) for k in range(3)]
    load = np.array([10.0, 30.0, 60.0])
    path = Paths.at_slip(np.full(3, 0.3), load, np.full(3, 0.114), travel=np.full(3, 0.15), step_count=1000)
    record = lead(ResistiveForceLaw(SOIL), wheels, path).mean(0.2)
    np.testing.assert_allclose(record.force_z, load, rtol=0.02)
    assert np.all(np.diff(record.sinkage) > 0)


def test_slip_and_skid_are_as_the_scenes_have_them():
    slip = np.array([0.0, 0.5, -0.4, -1.0])
    path = Paths.at_slip(slip, np.ones(4), np.full(4, 0.1), travel=np.full(4, 0.2), step_count=11)
    np.testing.assert_allclose(path.angle[-1] * 0.1, [0.2, 0.4, 0.12, 0.0])


def test_a_scenes_wheel_is_led_as_its_carriage_drives_it():
    scene = load_scene("pushed_wheel")
    paths, time = Paths.of_scene(scene)
    assert paths.load[0, 0] < 0.01 * scene.implement.normal_load
    assert paths.load[-1, 0] == scene.implement.normal_load
    assert np.abs(np.diff(paths.x[:, 0])).max() <= 1.001e-4
    for k in (-1, len(time) // 2):
        assert paths.x[k, 0] == pytest.approx(scene.program.travel(time[k]), abs=2e-4)
    assert np.all(paths.angle == 0)


def test_constants_are_found_again():
    measured = predict(ResistiveForceLaw(SOIL), trials())
    start = ResistiveSoil(
        scale=1.5e6, surface_friction=0.6, stiffness=7.5e6, shear_share=0.2, rut_share=0.5, damping_time=0.0
    )
    found = identify(measured, start)
    assert found.misfit < 0.1
    assert found.soil.scale == pytest.approx(SOIL.scale, rel=0.03)
    assert found.soil.surface_friction == pytest.approx(0.4, rel=0.05)
    assert found.soil.shear_share == pytest.approx(0.1, rel=0.1)
    assert found.soil.stiffness / found.soil.scale == pytest.approx(5.0)
    for name, estimate in found.estimates.items():
        assert estimate.low < estimate.value < estimate.high, name


def test_what_was_not_measured_counts_for_nothing():
    measured = [Trial(0.0, 10.0, 0.1, 0.05, sinkage=0.01), Trial(0.2, 10.0, 0.1, 0.05, 0.01, 1.0)]
    given = [Trial(0.0, 10.0, 0.1, 0.05, 0.011, 5.0, 5.0), Trial(0.2, 10.0, 0.1, 0.05, 0.01, 1.5, 5.0)]
    np.testing.assert_allclose(misfits(measured, given), [1.0, 0.0, 1.0])


def test_refuses_too_few_measurements_and_unknown_constants():
    few = [Trial(0.0, 10.0, 0.1, 0.05, sinkage=0.01), Trial(0.2, 10.0, 0.1, 0.05, drawbar_pull=1.0)]
    with pytest.raises(SoilError, match="2 measurements, more than 3 are needed"):
        identify(few, SOIL)
    with pytest.raises(SoilError, match="fitted = grip: allowed are scale"):
        identify(few, SOIL, fitted=("grip",))
