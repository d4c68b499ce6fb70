"""The elastic rim on a flat floor, against closed forms and balances."""

from dataclasses import replace

import numpy as np
import pytest

from synth.implements.ring import Ring, rest_on_floor, stiffened
from tests.synth.implements.ring_energy import elastic_energy

RADIUS, DEFLECTION = 0.1, 0.02


def ring(**changes) -> Ring:
    soft = Ring(
        node_count=360,
        node_radius=RADIUS,
        half_thickness=0.0,
        node_mass=0.01,
        radial_stiffness=300.0,
        tangential_stiffness=300.0,
        damping=0.0,
        hoop_stiffness=1e6,
        bending_stiffness=10.0,
    )
    return replace(soft, **changes)


def test_nodes_that_nothing_joins_carry_what_a_row_of_springs_does():
    """Springs as stiff along the rim as across push straight up: k (R cos a - (R - d)) over the contact."""
    alone = ring(hoop_stiffness=1e-6, bending_stiffness=1e-9)
    stiffness = alone.radial_stiffness / alone.bar_length  # per metre of rim
    half = np.arccos(1 - DEFLECTION / RADIUS)
    expected = 2 * stiffness * RADIUS * (RADIUS * np.sin(half) - (RADIUS - DEFLECTION) * half)
    assert rest_on_floor(alone, DEFLECTION).load == pytest.approx(expected, rel=2e-3)


def test_hub_and_floor_carry_the_same_and_nothing_goes_through_the_floor():
    joined = ring(tangential_stiffness=100.0)
    rest = rest_on_floor(joined, DEFLECTION)
    moved, outwards = rest.nodes - joined.unloaded, joined.unloaded / RADIUS
    along = np.stack([-outwards[:, 1], outwards[:, 0]], axis=1)
    radial = joined.radial_stiffness * (moved * outwards).sum(axis=1)
    tangential = joined.tangential_stiffness * (moved * along).sum(axis=1)
    on_hub = (radial[:, None] * outwards + tangential[:, None] * along).sum(axis=0)
    np.testing.assert_allclose(on_hub, [0.0, rest.load], rtol=1e-5, atol=1e-5 * rest.load)
    assert rest.nodes[:, 1].min() == pytest.approx(-(RADIUS - DEFLECTION), abs=0.01 * DEFLECTION)
    np.testing.assert_allclose(rest.nodes[1:180, 0], rest.nodes[179:0:-1, 0] * -1, atol=1e-6)


def test_work_done_on_the_axle_is_the_rims_energy():
    joined, depth = ring(), np.linspace(0, DEFLECTION, 41)
    rests = [rest_on_floor(joined, float(d)) for d in depth[1:]]
    load = np.array([0.0, *(rest.load for rest in rests)])
    assert elastic_energy(joined, rests[-1].nodes) == pytest.approx(np.trapezoid(load, depth), rel=0.01)


def test_foundation_is_as_stiff_as_the_deflection_asks_for():
    solved = stiffened(ring(), DEFLECTION, 500.0)
    assert rest_on_floor(solved, DEFLECTION).load == pytest.approx(500.0, rel=2e-3)
    assert solved.tangential_stiffness == pytest.approx(solved.radial_stiffness)


def test_a_rim_that_does_not_give_way_is_pushed_up_as_a_whole():
    stiff = ring(node_count=90, tangential_stiffness=100.0, hoop_stiffness=1e7, bending_stiffness=1e5)
    expected = 90 * (300.0 + 100.0) / 2 * DEFLECTION
    assert rest_on_floor(stiff, DEFLECTION).load == pytest.approx(expected, rel=0.01)
