import numpy as np
import pytest

from synth.drive import Cutting, Pushing, PushRolling, Rolling, Towed
from synth.implements import Bucket, RigidWheel

WHEEL = RigidWheel(kind="rigid_wheel", radius=0.1, width=0.05, normal_load=30.0, moving_mass=0.3)
BUCKET = Bucket(kind="bucket", width=0.1, cut_angle=30, blade_length=0.1, back_height=0.1, thickness=0.004)


def travel_to(program, end):
    times = np.linspace(program.time[0], end, 200_001)
    speed = np.interp(times, program.time, program.velocity_x)
    return np.trapezoid(speed, times)


def test_rolling_reaches_the_first_frame_after_the_run_in_at_constant_slip():
    program = Rolling(kind="rolling", rim_speed=0.01, slip=0.2, start=0.2, run_in=0.06).program(WHEEL)
    assert travel_to(program, 0.0) == pytest.approx(0.06, rel=1e-6)
    for time in (0.99 * program.time[0], 0.0, 7.0):
        vx, _, spin, load = program.at(time)
        assert vx == pytest.approx(0.8 * -spin * WHEEL.radius)
        assert 0 < load <= 1
    assert program.heaves


def test_pushing_stands_under_its_load_and_then_goes_backwards_without_turning():
    program = Pushing(kind="pushing", speed=0.005, start=0.3, loading=4.0, rest=1.0).program(WHEEL)
    assert program.at(-0.5) == (0.0, 0.0, 0.0, 1.0)
    assert program.at(2.0) == (-0.005, 0.0, 0.0, 1.0)
    least, greatest = program.reach_x(3.0)
    assert (least, greatest) == (pytest.approx(-0.005 * 2.8, rel=1e-3), 0.0)


def test_pushing_after_rolling_in_has_turned_as_far_as_it_rolled():
    program = Pushing(kind="pushing", speed=0.005, start=0.3, loading=4.0, rest=1.0, rolled_in=0.05).program(
        WHEEL
    )
    assert program.reach_x(0.0)[1] == pytest.approx(0.05 + 0.005 * 0.4, rel=1e-3)
    times = np.linspace(program.time[0], 0, 100_001)
    turned = np.trapezoid(np.interp(times, program.time, program.spin), times)
    # It stops turning where the rest begins, within the ramp.
    assert turned * WHEEL.radius == pytest.approx(-program.reach_x(0.0)[1], rel=0.01)
    assert program.at(1.0)[2] == 0.0


def test_cutting_goes_down_to_its_depth_and_stays_there():
    program = Cutting(kind="cutting", speed=0.01, depth=0.02, start=0.1, run_in=0.1).program(BUCKET)
    times = np.linspace(program.time[0], 5, 400_001)
    down = np.trapezoid(np.interp(times, program.time, program.velocity_z), times)
    assert down == pytest.approx(-0.02, rel=1e-4)
    assert program.at(1.0) == (0.01, 0.0, 0.0, 0.0)
    assert not program.heaves


@pytest.mark.parametrize("skid", [-1.0, -0.4])
def test_a_towed_wheel_turns_slower_than_it_travels(skid):
    program = Towed(kind="towed", speed=0.01, skid=skid, start=0.1, run_in=0.04).program(WHEEL)
    assert program.travel(0.0) == pytest.approx(0.04, rel=1e-6)
    for time in (0.99 * program.time[0], 0.0, 5.0):
        vx, _, spin, load = program.at(time)
        assert -spin * WHEEL.radius == pytest.approx(vx * (1 + skid))
        assert 0 < load <= 1


def test_a_cycle_of_push_rolling_rolls_rests_is_pushed_rests_and_rolls_on():
    drive = PushRolling(
        kind="push_rolling",
        speed=0.008,
        slip=0.2,
        start=0.15,
        loading=4.0,
        rest=0.5,
        rolled_in=0.05,
        pushed=0.012,
    )
    program = drive.program(WHEEL)
    assert program.at(program.time[0]) == (0, 0, 0, 0)
    assert program.travel(0.0) == pytest.approx(0.05)
    assert program.travel(0.0) - program.travel(1.8) == pytest.approx(0.012)
    assert program.at(0.8) == (-0.008, 0.0, 0.0, 1.0)
    for rest in (-0.2, 1.9):
        assert program.at(rest) == (0.0, 0.0, 0.0, 1.0)
    vx, _, spin, _ = program.at(5.0)
    assert 1 - vx / (-spin * WHEEL.radius) == pytest.approx(0.2)


def test_a_bucket_cannot_roll():
    with pytest.raises(ValueError, match=r"drive\.kind = 'rolling' needs a wheel, got .* 'bucket'"):
        Rolling(kind="rolling", rim_speed=0.01, slip=0.2, start=0.2, run_in=0.06).program(BUCKET)
