import numpy as np
import pytest

from synth.dem import relative_density
from synth.dem.grains import Grains, Spheres
from synth.dem.packing import slab_solid_fraction, solid_fraction, void_ratio
from synth.dem.relative_density import DIAMETER, settled_sample
from synth.devices import start_taichi
from synth.soil import GrainContact
from tests.synth.dem.bond_order import bond_orientational_order

CONTACT = GrainContact(
    friction=0.5, rolling_friction=0.2, restitution=0.5, wall_friction=0.5, implement_friction=0.5
)
DISORDERED, CRYSTAL = 0.6, 0.8
"""Bounds of the bond-orientational order: of a bed, and of what would be a crystal."""


def discs(x, z, radius):
    return Grains.at_rest(np.array([x, z], float), np.broadcast_to(radius, np.shape(x)).astype(float), 1.0)


def hexagons(rows, columns):
    row, column = np.divmod(np.arange(rows * columns), columns)
    return column + 0.5 * (row % 2), row * np.sqrt(3) / 2


@pytest.mark.parametrize(("x", "share"), [(0.0, 0.5), (1.0, 1.0), (-1.0, 0.0), (-0.5, 0.195501)])
def test_a_disc_that_a_side_cuts_counts_by_what_is_inside(x, share):
    found = solid_fraction(discs([x], [5.0], 1.0), left=0.0, right=10.0, bottom=0.0, top=10.0)
    assert found == pytest.approx(share * np.pi / 100, abs=1e-7)


@pytest.mark.parametrize(("x", "share"), [(0.0, 0.5), (1.0, 1.0), (-1.0, 0.0), (-0.5, 0.15625)])
def test_a_sphere_that_a_side_cuts_counts_by_what_is_inside(x, share):
    sphere = Spheres.at_rest(np.array([[x], [1.0], [5.0]]), np.array([1.0]), 1.0)
    found = slab_solid_fraction(sphere, left=0.0, right=10.0, bottom=0.0, top=10.0, thickness=2.0)
    assert found == pytest.approx(share * 4 / 3 * np.pi / 200, rel=1e-12)


def test_a_hexagonal_packing_fills_what_it_should():
    x, z = hexagons(40, 40)
    found = solid_fraction(discs(x, z, 0.5), left=5.0, right=30.0, bottom=5.0, top=5.0 + 28 * np.sqrt(3) / 2)
    assert found == pytest.approx(np.pi / np.sqrt(12), rel=0.002)
    assert void_ratio(0.8) == pytest.approx(0.25)


def test_bond_order_of_a_lattice_is_one_and_of_chance_is_small():
    lattice = np.array(hexagons(30, 30))
    assert bond_orientational_order(lattice, reach=1.2) == pytest.approx(1.0)
    turned = np.array([[0.8, -0.6], [0.6, 0.8]]) @ lattice
    assert bond_orientational_order(turned, reach=1.2) == pytest.approx(1.0)
    chance = np.random.default_rng(1).uniform(0, 30, (2, 900))
    assert bond_orientational_order(chance, reach=3.0) < 0.35


@pytest.mark.parametrize(("polydispersity", "crystalline"), [(0.2, False), (0.0, True)])
@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_spread_of_sizes_keeps_a_bed_from_crystallizing(monkeypatch, polydispersity, crystalline, friction):
    start_taichi()
    side = 20
    monkeypatch.setattr(relative_density, "SIDE", side)
    position = settled_sample(CONTACT, polydispersity, friction=friction, seed=1).position
    margin = 3 * DIAMETER
    inner = ((position > margin) & (position < side * DIAMETER - margin)).all(axis=0)
    order = bond_orientational_order(position[:, inner], reach=1.5 * DIAMETER)
    assert order > CRYSTAL if crystalline else order < DISORDERED
