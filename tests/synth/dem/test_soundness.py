"""Soundness of flows whose inertial number is known."""

from dataclasses import replace

import numpy as np
import pytest

from synth.dem.contact_law import ContactLaw
from synth.dem.grains import Grains
from synth.dem.log import Frame
from synth.dem.soundness import QUANTITIES, judge, moving_soil, weighted_quantile
from synth.dem.tool import Tool
from synth.implements import Shape

RADIUS, DENSITY, STIFFNESS, OVERLAP = 1e-3, 2000.0, 1e6, 1e-5
LAW = ContactLaw(STIFFNESS, 0.5 * STIFFNESS, 0.1, 0.5, 0.5, 0.5, 0.1)
SPACING = 2 * RADIUS - OVERLAP
BULK = DENSITY * np.pi * RADIUS**2 / (np.sqrt(3) / 2 * SPACING**2)


def sheared_lattice(rate, count=24):
    """A triangular lattice under pressure ``sqrt(3) k overlap / spacing``, in simple shear."""
    row, column = np.divmod(np.arange(count**2), count)
    position = SPACING * np.stack([column + 0.5 * (row % 2), np.sqrt(3) / 2 * row]) + 0.01
    grains = Grains.at_rest(position, np.full(count**2, RADIUS), DENSITY)
    return replace(grains, velocity=np.stack([rate * position[1], 0 * position[1]]))


def far_tool(speed):
    return Tool(Shape.disc(0.01), x=5.0, z=5.0, velocity_x=speed)


def test_inertial_number_of_simple_shear():
    rate = 3.0
    soil = moving_soil(Frame(far_tool(0.01), sheared_lattice(rate)), LAW, BULK)
    numbers = soil.inertial_number
    pressure = np.sqrt(3) * STIFFNESS * OVERLAP / SPACING
    # Grains at the edges have fewer contacts; all others are alike.
    expected = rate * 2 * RADIUS * np.sqrt(DENSITY / pressure)
    assert np.median(numbers) == pytest.approx(expected, rel=1e-6)
    assert numbers.min() == pytest.approx(expected, rel=1e-6)
    assert np.median(soil.load) == pytest.approx(pressure * np.pi * RADIUS**2, rel=1e-6)


def test_inertial_number_knows_the_grains_around():
    # The same soil, beside it of grains twice as large: the number is theirs, pressure is the same.
    rate, fine = 3.0, sheared_lattice(3.0)
    side = np.ptp(fine.position[0]) + 0.05
    coarse = replace(
        fine,
        position=2 * fine.position + [[side], [0.0]],
        velocity=2 * fine.velocity,
        radius=2 * fine.radius,
    )
    both = [
        np.concatenate([getattr(g, n) for g in (fine, coarse)], axis=-1) for n in ("position", "velocity")
    ]
    radius = np.concatenate([fine.radius, coarse.radius])
    mixed = replace(Grains.at_rest(both[0], radius, DENSITY), velocity=both[1])
    numbers = moving_soil(Frame(far_tool(0.01), mixed), LAW, BULK).inertial_number
    pressure = np.sqrt(3) * STIFFNESS * OVERLAP / SPACING
    single = rate * 2 * RADIUS * np.sqrt(DENSITY / pressure)
    assert np.quantile(numbers, 0.25) == pytest.approx(single, rel=1e-6)
    assert np.quantile(numbers, 0.75) == pytest.approx(2 * single, rel=1e-6)


def test_weighted_quantile_of_a_known_case():
    # Up to the value v in 1..100, weights v hold v (v + 1) / 2 of 5050: half of it at 71, 95 % at 98.
    values = np.arange(1.0, 101.0)
    shuffled = np.random.default_rng(0).permutation(values)
    assert weighted_quantile(shuffled, shuffled, 0.5) == 71.0
    assert weighted_quantile(shuffled, shuffled, 0.95) == 98.0
    assert weighted_quantile(shuffled, np.ones(100), 0.95) == 95.0
    assert weighted_quantile(np.array([5.0, 1.0]), np.array([0.0, 2.0]), 1.0) == 1.0


def test_turning_as_a_whole_is_no_shear():
    grains = sheared_lattice(0.0)
    x, z = grains.position
    turning = replace(grains, velocity=np.stack([-2.0 * z, 2.0 * x]))
    numbers = moving_soil(Frame(far_tool(0.01), turning), LAW, BULK).inertial_number
    assert numbers.size and numbers.max() < 1e-9


def test_soil_at_rest_and_an_implement_at_rest_have_none():
    assert moving_soil(Frame(far_tool(0.1), sheared_lattice(0.0)), LAW, BULK).inertial_number.size == 0
    assert moving_soil(Frame(far_tool(0.0), sheared_lattice(3.0)), LAW, BULK).inertial_number.size == 0


def test_soil_that_carries_nothing_is_left_out():
    loose = sheared_lattice(3.0)
    apart = replace(loose, position=1.1 * loose.position)
    assert moving_soil(Frame(far_tool(0.01), apart), LAW, BULK).inertial_number.size == 0


@pytest.mark.parametrize(
    ("attribute", "good", "bad"),
    [
        ("inertial_number_carrying_p95", 2e-3, 4e-3),
        ("stiffness_ratio", 1500.0, 900.0),
        ("overlap_p99", 0.005, 0.011),
        ("steps_per_contact", 20.0, 15.0),
    ],
)
def test_limits(attribute, good, bad):
    (kept,), (broken,) = judge({attribute: good}), judge({attribute: bad})
    assert kept.kept and not broken.kept
    assert broken.advice.startswith("take ") and broken.limit


def test_a_run_reports_every_quantity(tiny_wheel, tiny_recording):
    attributes = tiny_recording.data.attrs
    always = {quantity.attribute for quantity in QUANTITIES if "density" not in quantity.attribute}
    assert always <= set(attributes)
    assert 0 < attributes["inertial_number_median"] < attributes["inertial_number_p95"]
    # The soil that carries the load is not the soil that moves fastest.
    assert 0 < attributes["inertial_number_carrying_p95"] < attributes["inertial_number_p95"]
    assert attributes["overlap_mean"] < attributes["overlap_p99"] <= attributes["overlap_max"]
    assert attributes["steps_per_contact"] >= tiny_wheel.contact.steps_per_contact
    pressure, stiffness = attributes["mean_pressure"], tiny_wheel.contact.normal_stiffness
    assert attributes["stiffness_ratio"] == pytest.approx(stiffness / pressure)
    # The load on a contact about as long as a fifth to one radius.
    load = tiny_wheel.implement.normal_load / tiny_wheel.implement.width
    assert load / tiny_wheel.implement.radius < pressure < 5 * load / tiny_wheel.implement.radius
