"""The vehicle on soil: statics, mirror symmetry, energy, and what a law is told first."""

import mujoco
import numpy as np
import pytest

from synth.rover.balance import Balance
from synth.rover.gaits import Rolling, held_command
from synth.rover.law.catalogue import make_law
from synth.rover.ride import Ride
from synth.rover.vehicle import load_vehicle
from tests.synth.rover.energy_ledger import EnergyLedger
from tests.synth.rover.slipping import SlippingLaw

STANCES = ("high", "middle", "low")


def at_rest(vehicle, law, stance, *, pull=0.0, seconds=2.0):
    ride = Ride(vehicle, law, stance=stance)
    ride.pull = pull
    held = held_command(vehicle, stance)
    for _ in range(round(seconds / ride.time_step)):
        ride.step(held)
    return ride


def test_a_law_is_first_told_where_the_wheels_are(scarab):
    law = SlippingLaw()
    Ride(scarab, law, stance="low").step(held_command(scarab, "low"))
    assert law.first.z == pytest.approx(0.355, abs=1e-4)  # 0 before mj_forward
    assert sorted(law.first.x) == pytest.approx([-0.65, -0.65, 0.65, 0.65], abs=1e-4)
    assert law.first.spin == pytest.approx(0, abs=1e-12)


def test_velocities_of_the_axles_are_those_of_mujoco(scarab):
    ride = Ride(scarab, SlippingLaw(), stance="middle")
    ride.data.qvel[:] = np.random.default_rng(0).normal(size=scarab.model.nv)
    mujoco.mj_forward(scarab.model, ride.data)
    states, found = ride.wheel_states(), np.zeros(6)
    for index, wheel in enumerate(scarab.wheels):
        mujoco.mj_objectVelocity(scarab.model, ride.data, mujoco.mjtObj.mjOBJ_XBODY, wheel.body, found, 0)
        told = states.spin[index], states.velocity_x[index], states.velocity_z[index]
        assert told == pytest.approx((found[1], found[3], found[5]))


@pytest.mark.parametrize(("stance", "wheel"), [*((one, "rigid") for one in STANCES), ("low", "pneumatic")])
def test_every_pose_stands_and_the_wheels_bear_the_weight(scarab, stance, wheel):
    ride = at_rest(scarab, make_law("rft", wheel=wheel), stance)
    assert ride.forces.force_z.sum() == pytest.approx(scarab.weight, rel=0.01)
    assert ride.forces.force_z == pytest.approx(scarab.weight / 4, rel=0.03)
    assert np.abs(ride.data.qvel).max() < 0.01
    assert np.all(ride.states.z < 0.355)


def test_the_cable_moves_load_to_the_rear_axle(scarab):
    pull = 400.0
    ride = at_rest(scarab, SlippingLaw(), "middle", pull=pull)
    forces, states = ride.forces, ride.states
    front, rear = states.x > states.x.mean(), states.x < states.x.mean()
    assert forces.force_x.sum() == pytest.approx(pull, rel=1e-3)
    # The cable pulls at the axles: what shifts the load is the moment of the soil's thrust on the rims.
    shifted = (forces.force_z[rear].sum() - forces.force_z[front].sum()) / 2 * np.ptp(states.x)
    assert shifted == pytest.approx(pull * 0.355, rel=0.03)


def test_left_and_right_do_the_same(scarab):
    gait = Rolling(scarab)
    ride = Ride(scarab, make_law("rft"), stance=gait.stance)
    ride.pull = 300.0
    for _ in range(1500):
        ride.step(gait.command(ride.time))
    left = np.array([wheel.placed.track == "left" for wheel in scarab.wheels])
    for values in (ride.forces.force_x, ride.forces.force_z, ride.forces.torque, ride.states.x):
        assert values[left] == pytest.approx(values[~left], rel=1e-4)
    assert abs(ride.data.qpos[1]) < 1e-6


def driven(vehicle, *, pull, seconds, time_step=0.001):
    """Speed (m/s), work and mean forces of a ride since it moves steadily."""
    gait = Rolling(vehicle)
    ride = Ride(vehicle, make_law("rft"), stance=gait.stance, time_step=time_step)
    settled, steady = round(1.0 / time_step), round(2.5 / time_step)
    ledger = balance = None
    for step in range(steady + round(seconds / time_step)):
        if step == settled:
            ride.pull = pull
        if step == steady:
            ledger, balance, start = EnergyLedger(ride), Balance(ride), ride.travel
        ride.step(gait.command(max(0.0, ride.time - 1.0)))
        if ledger:
            ledger.add()
            balance.add("roll")
    return (ride.travel - start) / seconds, ledger.work(), balance.means()[0]


def test_without_a_load_it_drives_itself_and_slips_a_little(scarab):
    speed, work, mean = driven(scarab, pull=0.0, seconds=2.0)
    assert 0.005 < 1 - speed / 0.06 < 0.15
    assert work.cable == 0
    assert work.motors > 0
    assert abs(mean.pull) < 0.005 * scarab.weight
    assert all(wheel.torque < 0 for wheel in mean.wheels)


def test_work_of_the_motors_is_found_again(scarab):
    speed, work, _ = driven(scarab, pull=300.0, seconds=2.0)
    assert work.cable == pytest.approx(300.0 * speed * 2.0, rel=0.02)
    assert work.soil > 0
    assert abs(work.missing) < 0.02 * work.motors


def test_half_the_time_step_changes_the_speed_under_load_little(scarab):
    speed, _, _ = driven(scarab, pull=300.0, seconds=1.0)
    finer, _, _ = driven(scarab, pull=300.0, seconds=1.0, time_step=0.0005)
    assert finer == pytest.approx(speed, rel=0.02)


def test_another_vehicle_rides():
    vehicle = load_vehicle("rocker_bogie")
    gait = Rolling(vehicle)
    ride = Ride(vehicle, make_law("rft"))
    for _ in range(2500):
        ride.step(gait.command(max(0.0, ride.time - 1.0)))
    assert 0.8 < ride.travel / (0.06 * 1.25) < 1.0
    assert ride.forces.force_z.sum() == pytest.approx(vehicle.weight, rel=0.05)
