import numpy as np
import pytest

from synth.rover.gaits import CONTRACT, EXPAND, Inching, Rolling, make_gait
from synth.rover.law.catalogue import make_law
from synth.rover.ride import Ride
from synth.rover.vehicle import VehicleError, load_vehicle


def arm_angle(gait, spread):
    """Of the front arm in the world, rad, against the start."""
    return -(spread - gait.frame.spread(0.8)) / 2


def by_name(vehicle, told):
    return {vehicle.model.actuator(index).name: value for index, value in enumerate(told)}


def test_pushing_wheels_are_told_to_stand_still_in_the_world(scarab):
    gait = Inching(scarab)
    for time in np.linspace(0, gait.cycle, 40, endpoint=False):
        told = by_name(scarab, gait.command(time))
        arm = arm_angle(gait, told["left_spread"])
        front, rear = told["front_left_wheel"] + arm, told["rear_left_wheel"] - arm
        rolled = 0.5 / 0.355
        if gait.phase(time) == EXPAND:
            assert rear == pytest.approx(0, abs=1e-9)
            assert 0 <= front <= rolled
        else:
            assert gait.phase(time) == CONTRACT
            assert front == pytest.approx(rolled)


def test_inching_goes_from_the_shortest_to_the_longest_wheelbase_and_back(scarab):
    gait = Inching(scarab, speed=0.05, shortest=0.9, longest=1.2)
    times = np.linspace(0, gait.cycle, 2001)
    bases = np.array([gait.frame.wheelbase(by_name(scarab, gait.command(t))["right_spread"]) for t in times])
    assert (bases.min(), bases.max()) == pytest.approx((0.9, 1.2), abs=1e-4)
    assert np.abs(np.gradient(bases, times)).max() == pytest.approx(0.05, rel=0.01)
    assert bases[[0, -1]] == pytest.approx(0.9)


def test_rolled_way_of_a_cycle_is_the_stroke(scarab):
    gait = Inching(scarab)
    after = np.array(gait.command(gait.cycle)) - gait.command(0.0)
    assert after[2:] == pytest.approx(0.5 / 0.355)
    assert after[:2] == pytest.approx(0)


@pytest.mark.parametrize("name", ["scarab", "rocker_bogie"])
def test_rolling_wheels_keep_the_rim_speed(name):
    vehicle = load_vehicle(name)
    gait, wheel = Rolling(vehicle, speed=0.04), vehicle.wheels[0]
    late, later = (gait.command(time)[wheel.actuator] for time in (5.0, 6.0))
    rate = later if name == "rocker_bogie" else later - late  # velocity servos there
    assert rate * wheel.placed.radius == pytest.approx(0.04)


def test_inching_on_soil_moves_forward_and_pushing_wheels_hardly_turn(scarab):
    gait = Inching(scarab, shortest=0.8, longest=0.95)
    ride = Ride(scarab, make_law("rft"), stance=gait.stance)
    for _ in range(1500):
        ride.step(gait.command(0.0))
    start, turned = ride.travel, ride.states.angle.copy()
    for _ in range(round(gait.cycle / 2 / ride.time_step)):
        ride.step(gait.command(ride.time - 1.5))
    rear = scarab.rear_wheels
    assert np.abs(ride.states.angle - turned)[rear] == pytest.approx(0, abs=0.02)
    assert ride.travel - start == pytest.approx(0.15 / 2, rel=0.1)


def test_refuses_what_cannot_be_done(scarab):
    for speed in (0.0, -1.0, float("nan")):
        with pytest.raises(VehicleError, match="must be positive"):
            Rolling(scarab, speed=speed)
    with pytest.raises(VehicleError, match=r"0\.5 m: this vehicle allows"):
        Inching(scarab, shortest=0.5)
    with pytest.raises(VehicleError, match="the first must be the smaller"):
        Inching(scarab, shortest=1.2, longest=0.9)
    with pytest.raises(VehicleError, match="stance 'flat': it has high, middle, low"):
        Rolling(scarab, stance="flat")
    with pytest.raises(VehicleError, match="gait 'crawling': allowed are rolling, inching"):
        make_gait("crawling", scarab)
    with pytest.raises(VehicleError, match="no actuator 'left_spread'"):
        make_gait("inching", load_vehicle("rocker_bogie"))
