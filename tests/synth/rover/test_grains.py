"""The exchange between a vehicle and grains."""

from dataclasses import replace

import numpy as np
import pytest

from synth.dem.bed import contact_law
from synth.dem.contact_law import time_step_of
from synth.dem.solver import Solver
from synth.dem.tool import Tool
from synth.devices import start_taichi
from synth.implements import Shape
from synth.rover.grains.granular_soil import GranularSoil
from synth.rover.grains.wheels_solver import WheelPlaces, WheelsSolver
from synth.rover.law.interface import PlacedWheel, WheelStates
from synth.rover.law.response import SoilError
from tests.synth.rover.grains_bed import rows_of_discs, small_scene

WHEEL_RADIUS, HEIGHT = 0.1, 0.1855
EXCHANGE = 1e-3


@pytest.fixture(scope="module")
def bed():
    start_taichi("cpu", 1)
    scene = small_scene()
    return scene, rows_of_discs(scene)


def numerics(scene, bed):
    law = contact_law(scene)
    largest = time_step_of(bed.grains, law, scene.contact.steps_per_contact)
    steps = int(np.ceil(EXCHANGE / largest))
    return law, EXCHANGE / steps, steps


def places(*wheels):
    return WheelPlaces(*np.array(wheels, float).T)


def test_one_wheel_led_is_the_solvers_own_implement(bed):
    scene, bed = bed
    law, time_step, steps = numerics(scene, bed)
    speed, sinking, spin = 0.05, -0.04, -0.8
    tool = Tool(shape=Shape.disc(WHEEL_RADIUS), x=0.4, z=HEIGHT)
    own = Solver(bed.grains, law, scene.bed.width, time_step, tool=tool)
    start = places((0.4, HEIGHT, 0.0))
    led = WheelsSolver(bed.grains, law, scene.bed.width, time_step, radius=(WHEEL_RADIUS,), places=start)
    for exchange in range(1, 31):
        own.drive_tool(velocity_x=speed, velocity_z=sinking, spin=spin, load=0.0)
        own.advance(steps)
        impulse = own.take_tool_impulse()
        time = exchange * EXCHANGE
        loads = led.lead(places((0.4 + speed * time, HEIGHT + sinking * time, spin * time)), steps)
        mean = np.array([impulse.x, impulse.z, impulse.moment]) / EXCHANGE
        found = np.array([loads.force_x[0], loads.force_z[0], loads.moment[0]])
        assert found == pytest.approx(mean, rel=1e-6, abs=1e-3)
    assert mean[1] > 100  # it is well in the grains
    assert led.read_grains().position == pytest.approx(own.read_grains().position, abs=1e-9)


def test_two_wheels_are_told_apart(bed):
    scene, bed = bed
    law, time_step, steps = numerics(scene, bed)
    start = places((0.3, HEIGHT, 0.0), (0.8, HEIGHT + 0.05, 0.0))
    solver = WheelsSolver(
        bed.grains, law, scene.bed.width, time_step, radius=(WHEEL_RADIUS,) * 2, places=start
    )
    for exchange in range(1, 11):
        down = 1e-4 * exchange
        loads = solver.lead(places((0.3, HEIGHT - down, 0.0), (0.8, HEIGHT + 0.05 - down, 0.0)), steps)
    assert loads.force_z[0] > 10
    assert loads.force_z[1] == 0
    assert solver.places.z == pytest.approx([HEIGHT - 1e-3, HEIGHT + 0.049])


def four(x, z, angle=(0.0, 0.0)):
    """States of front and rear wheels on both sides, at rest."""
    spread = [np.array([one[0], one[1], one[0], one[1]], float) for one in (x, z, angle)]
    still = np.zeros(4)
    return WheelStates(spread[0], spread[1], still, still, spread[2], still)


def placed(name, width=0.18):
    return PlacedWheel(name, name.split("_")[1], WHEEL_RADIUS, width)


NAMES = ("front_left", "rear_left", "front_right", "rear_right")


def pressed(scene, bed, width=0.18):
    soil = GranularSoil(scene, bed)
    soil.place([placed(name, width) for name in NAMES])
    x, forces = (0.35, -0.1), None
    for exchange in range(40):
        sunk = 1e-4 * exchange
        forces = soil.advance(four(x, (WHEEL_RADIUS - sunk, WHEEL_RADIUS - sunk)), EXCHANGE)
    return soil, forces


def test_both_tracks_feel_the_grains_times_their_width(bed):
    soil, forces = pressed(*bed)
    assert forces.force_z[:2] == pytest.approx(forces.force_z[2:])
    assert (forces.force_z > 5).all()
    _, wider = pressed(*bed, width=0.36)
    assert wider.force_z == pytest.approx(2 * forces.force_z)
    rut = soil.rut("left")
    under = np.abs(rut[:, 0] - 0.35) < 0.02
    assert rut[under, 1].max() < 1e-3  # no grain stands above the rim that was pressed in


def test_tracks_that_part_are_held_together(bed):
    soil, _ = pressed(*bed)
    even = four((0.35, -0.1), (WHEEL_RADIUS - 4e-3, WHEEL_RADIUS - 4e-3))
    tilted = replace(even, z=even.z + np.array([1e-3, 1e-3, -1e-3, -1e-3]))
    forces = soil.advance(tilted, EXCHANGE)
    assert forces.force_z[2:] - forces.force_z[:2] == pytest.approx(2e5 * 1e-3)
    assert forces.force_x[:2] == pytest.approx(forces.force_x[2:])
    assert forces.force_z[:2].mean() + 1e5 * 1e-3 == pytest.approx(forces.force_z.mean())


def test_a_driven_wheel_thrusts_and_meets_a_torque(bed):
    scene, bed = bed
    soil, _ = pressed(scene, bed)
    sunk = 39e-4
    for exchange in range(60):
        angle = 2e-3 * exchange
        z = (WHEEL_RADIUS - sunk, WHEEL_RADIUS - sunk)
        forces = soil.advance(four((0.35, -0.1), z, (angle, 0.0)), EXCHANGE)
    assert forces.force_x[0] > 0.1 * forces.force_z[0]
    assert forces.torque[0] < 0
    assert abs(forces.torque[0]) == pytest.approx(forces.force_x[0] * WHEEL_RADIUS, rel=0.5)


def test_the_end_of_the_bin_is_told(bed):
    soil, _ = pressed(*bed)
    with pytest.raises(SoilError, match="a longer bin is needed"):
        soil.advance(four((0.95, 0.5), (0.1, 0.1)), EXCHANGE)


def test_tracks_have_to_be_alike(bed):
    with pytest.raises(SoilError, match="have to be alike"):
        GranularSoil(*bed).place([placed(name) for name in NAMES[:3]])
