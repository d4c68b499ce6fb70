from dataclasses import replace

import numpy as np
import pytest

from synth.rover.law import rft
from synth.rover.law.interface import PlacedWheel, WheelStates
from synth.rover.law.response import SoilError, generic_response
from synth.rover.law.rft import ResistiveForceLaw, ResistiveSoil
from synth.rover.law.single_wheel import Paths, lead

RADIUS, WIDTH = 0.355, 0.18


def sink_and_roll(travel=0.5, slip=0.2, sinkage=0.03, step=2e-4):
    """Down to a sinkage, then rolling at it."""
    down = np.linspace(0, sinkage, int(sinkage / step))
    along = np.arange(0, travel, step)
    x = np.concatenate([np.zeros_like(down), along])
    return x, np.concatenate([down, np.full_like(along, sinkage)]), x / (1 - slip) / RADIUS


def steady_integral(soil, slip, sinkage):
    """Published traction over the leading part of the rim, by quadrature: force_x, force_z, torque."""
    entry = np.arccos(1 - sinkage / RADIUS)
    edge = np.linspace(0, entry, 20_001)
    angle = (edge[1:] + edge[:-1]) / 2
    sine, cosine = np.sin(angle), np.cos(angle)
    velocity = np.stack([1 - cosine / (1 - slip), -sine / (1 - slip)])
    velocity /= np.hypot(*velocity)
    generic = generic_response(sine, -cosine, *velocity)
    level = soil.scale * (sinkage - RADIUS * (1 - cosine)) * WIDTH * RADIUS * np.diff(edge)
    pressure = level * generic.pressure
    shear = np.clip(
        level * generic.shear, -soil.surface_friction * pressure, soil.surface_friction * pressure
    )
    force_x, force_z = shear * cosine - pressure * sine, shear * sine + pressure * cosine
    return np.array([force_x.sum(), force_z.sum(), -RADIUS * shear.sum()])


@pytest.mark.parametrize("slip", [0.1, 0.4, -0.3])
def test_steady_rolling_in_stiff_soil_is_the_published_integral(soil, place, move, slip, monkeypatch):
    monkeypatch.setattr(rft, "_LEASH", 1e-4)  # no memory of the direction
    # At shallow depth the rut's memory has no part in it: what leads meets fresh soil.
    stiff = replace(soil, stiffness=1e9, shear_share=1.0)
    rim = 1 / (1 - slip) if slip >= 0 else 1 + slip
    x, sinkage, _ = sink_and_roll()
    found = move(place(stiff, element_count=400), x, sinkage, x * rim / RADIUS)[-500:].mean(axis=0)
    expected = steady_integral(stiff, 1 - 1 / rim, 0.03)
    np.testing.assert_allclose(found, expected, rtol=0.05, atol=0.01 * expected[1])


def test_elements_are_fine_enough(place, move):
    coarse, fine = (move(place(element_count=n), *sink_and_roll())[-500:].mean(axis=0) for n in (64, 256))
    np.testing.assert_allclose(coarse, fine, rtol=0.02)


def test_halving_the_step_changes_little(place, move):
    coarse, fine = (
        move(place(), *sink_and_roll(step=step))[-int(0.1 / step) :].mean(axis=0) for step in (4e-4, 2e-4)
    )
    np.testing.assert_allclose(coarse, fine, rtol=0.02)


def test_driving_the_other_way_mirrors_the_forces(place, move):
    x, sinkage, angle = sink_and_roll()
    ahead, back = move(place(), x, sinkage, angle)[-500:], move(place(), -x, sinkage, -angle)[-500:]
    np.testing.assert_allclose(ahead.mean(axis=0) * [-1, 1, -1], back.mean(axis=0), rtol=0.01)


def test_one_wheel_of_many_is_as_it_is_alone(place, move):
    x, sinkage, angle = sink_and_roll(travel=0.2)
    alone = move(place(), x, sinkage, angle)
    law = place(count=3)
    still, place_x = np.zeros(3), np.array([0.0, 1.0, 2.0])
    for k in range(len(x)):
        by = [one[k] - one[max(k - 1, 0)] for one in (x, -sinkage, angle)]
        z = RADIUS - sinkage[k]
        states = WheelStates(
            place_x + x[k], still + z, still + by[0], still + by[1], still + angle[k], still + by[2]
        )
        forces = law.advance(states, 1.0)
    np.testing.assert_allclose(forces.force_x[0], alone[-1, 0], rtol=1e-9)
    np.testing.assert_allclose(forces.force_z, alone[-1, 1], rtol=0.02)


def test_no_traction_exceeds_flowing_soil(soil, place):
    """Pressure stays below what soil bears anywhere, shear below surface friction."""
    law, rng = place(), np.random.default_rng(3)
    x, z, angle, moved = 0.0, RADIUS, 0.0, np.zeros(3)
    greatest, highest = soil.scale * 0.06, 0.0  # a plate's value is below 1, the wheel above 60 mm
    for _ in range(3000):
        moved = 0.95 * moved + rng.normal(0, [1e-4, 3e-5, 3e-4])
        moved[1] += 0.02 * (RADIUS - 0.03 - z)
        x, z, angle = np.array([x, z, angle]) + moved
        law.advance(
            WheelStates(*(np.array([one]) for one in (x, z, moved[0], moved[1], angle, moved[2]))), 1.0
        )
        assert law.pressure.min() >= 0
        assert np.all(np.abs(law.shear) <= soil.surface_friction * law.pressure + 1e-6)
        assert RADIUS - z < 0.06
        highest = max(highest, law.pressure.max())
    assert 0.1 * greatest < highest <= greatest


def test_unloading_is_elastic_and_reloading_goes_the_same_way(soil, place, move):
    law = place()
    down = np.linspace(0, 0.03, 300)
    move(law, 0.0, down, 0.0)
    pressed = law.pressure.copy()
    out = 0.03 - np.linspace(0, 1e-4, 11)
    there = move(law, 0.0, out, 0.0)[:, 1]
    back = move(law, 0.0, out[::-1], 0.0)[:, 1]
    np.testing.assert_allclose(back[::-1], there, rtol=1e-6)
    np.testing.assert_allclose(law.pressure, pressed, rtol=1e-6, atol=1e-6 * pressed.max())
    # Slope: stiffness over the projected contact, pressure acting along the elements' normals.
    slope = (there[0] - there[-1]) / 1e-4
    entry = np.arccos(1 - 0.03 / RADIUS)
    assert slope == pytest.approx(soil.stiffness * WIDTH * RADIUS * (entry + np.sin(2 * entry) / 2), rel=0.08)


@pytest.mark.parametrize("direction", ["up", "along"])
@pytest.mark.parametrize("rolls", [True, False])
def test_vibration_of_15_hz_does_not_change_the_mean_force(place, move, direction, rolls):
    """0.05 mm at 15 Hz and 0.04 m/s: an eighth of the speed."""
    step = 4e-5  # a millisecond
    sinkage = np.concatenate([np.linspace(0, 0.03, 500), np.full(4000, 0.03)])
    travel = np.concatenate([np.zeros(500), step * np.arange(4000)]) * rolls
    shaken = 5e-5 * np.sin(2 * np.pi * 15 * 1e-3 * np.arange(4500)) * (np.arange(4500) > 1500)
    angle = travel / 0.8 / RADIUS
    steady = move(place(), travel, sinkage, angle)
    up, along = shaken * (direction == "up"), shaken * (direction == "along")
    other = move(place(), travel + along, sinkage + up, angle)
    change = np.abs(other[-2000:].mean(axis=0) - steady[-2000:].mean(axis=0)) / steady[-1, 1]
    assert change[0] < 0.005
    # A wheel that stands unloads by what it is shaken by and is held at that height.
    assert change[1] < (0.005 if rolls else 0.015)


def test_a_closed_path_costs_work(place, move):
    """Whatever way a wheel goes, standing again where it stood with nothing on it, the soil took work."""
    for seed in range(4):
        rng = np.random.default_rng(seed)
        wander = np.cumsum(rng.normal(0, [2e-4, 2e-4, 6e-4], (1500, 3)), axis=0)
        wander[:, 1] = 0.02 + 0.02 * np.sin(np.linspace(0, 20, 1500)) + 0.1 * wander[:, 1]
        wander[0, 1], wander[-1, 1] = -0.05, -0.05
        x, sinkage, angle = wander.T
        forces = move(place(), x, sinkage, angle)
        by = np.diff(np.stack([x, -sinkage, angle], axis=1), axis=0)
        work_on_soil = -np.sum((forces[1:] + forces[:-1]) / 2 * by)
        assert work_on_soil > 0.1


def test_a_second_wheel_in_the_rut_stands_lower_and_pays_less_in_hardened_soil(soil):
    law = ResistiveForceLaw(replace(soil, rut_share=0.8, hardening=1.5))
    wheels = [PlacedWheel("front", "left", RADIUS, WIDTH), PlacedWheel("rear", "left", RADIUS, WIDTH)]
    path = Paths.at_slip(
        np.zeros(2), np.full(2, 700.0), np.full(2, RADIUS), travel=np.array(2.0), step_count=3000
    )
    path = replace(path, x=path.x + np.array([1.0, 0.0]))
    record = lead(law, wheels, path).mean(0.2)
    front, rear = record.sinkage
    assert rear > front + 0.003
    assert rear - 0.8 * front < 0.9 * front
    assert record.force_x[0] < record.force_x[1] < 0
    rut = law.rut("left")
    behind = rut[(rut[:, 0] > 2.2) & (rut[:, 0] < 2.8), 1]
    np.testing.assert_allclose(behind, -0.8 * front, rtol=0.1)


def test_hardened_soil_bears_more_where_a_wheel_has_passed(soil, place, move):
    x, sinkage, angle = sink_and_roll(travel=0.3, slip=0.0)
    back = slice(None, 600, -1)
    path = [np.append(one, one[back]) for one in (x, sinkage, angle)]
    plain, hard = (move(place(replace(soil, rut_share=0.0, hardening=one)), *path) for one in (1.0, 1.5))
    np.testing.assert_array_equal(plain[:150], hard[:150])
    assert hard[-300:, 1].mean() > 1.2 * plain[-300:, 1].mean()


def test_a_braked_wheel_mobilises_within_millimetres(place, move):
    x, sinkage, angle = sink_and_roll(travel=0.3, slip=0.0)
    law = place()
    before = move(law, x, sinkage, angle)[-1, 0]
    pushed = move(law, x[-1] - np.arange(0, 0.01, 1e-4), sinkage[-1], angle[-1])[:, 0]
    assert before < 0 < pushed[-1]
    assert pushed[40] > 0.7 * pushed[-1]


def test_an_elastic_rim_flattens_and_a_stiff_one_is_rigid(soil, place, move):
    rigid, stiff, soft = (ResistiveForceLaw(soil, rim_stiffness=one) for one in (None, 1e9, 1e6))
    wheel, path = (
        [PlacedWheel("", "", RADIUS, WIDTH)],
        Paths(np.zeros((800, 1)), np.zeros((800, 1)), np.full((800, 1), 700.0)),
    )
    records = [lead(law, wheel, path) for law in (rigid, stiff, soft)]
    assert records[1].sinkage[-1, 0] == pytest.approx(records[0].sinkage[-1, 0], rel=0.02)
    contact = [np.count_nonzero(law.pressure > 0.1 * law.pressure.max()) for law in (rigid, stiff, soft)]
    assert contact[2] > 1.2 * contact[0]
    assert soft.pressure.max() < 0.85 * rigid.pressure.max()
    for record in records:
        assert record.force_z[-1, 0] == pytest.approx(700, rel=0.01)


def test_what_was_remembered_is_forgotten(place, move):
    law, path = place(), sink_and_roll(travel=0.1)
    first = move(law, *path)
    law.reset()
    np.testing.assert_array_equal(move(law, *path), first)


@pytest.mark.parametrize(
    "name, value", [("scale", 0.0), ("stiffness", -1.0), ("rut_share", 1.5), ("damping_time", -1.0)]
)
def test_refuses_a_soil_that_cannot_be(soil, name, value):
    with pytest.raises(SoilError, match=rf"{name} = {value}: .* is allowed"):
        replace(soil, **{name: value})


def test_refuses_to_place_no_wheel(soil):
    with pytest.raises(SoilError, match="wheels: at least one is needed"):
        ResistiveForceLaw(soil).place([])


def test_soil_of_a_name_that_is_none():
    with pytest.raises(TypeError):
        ResistiveSoil(scale=1.0, surface_friction=0.5, stiffness=1.0, grip=2.0)
