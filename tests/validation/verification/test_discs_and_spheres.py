"""Cases that discs and spheres have in common: what they are built from, and that they can fail."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from synth.dem.grains import Grains, Spheres
from synth.devices import start_taichi
from synth.scene import GRAVITY
from validation.verification import biaxial, column_collapse, repose, silo, suite
from validation.verification.contact_forces import contact_forces
from validation.verification.discs import advance_for, law
from validation.verification.packing import DIAMETER, Box, moved

BOXES = {"discs": Box(8 * DIAMETER), "spheres": Box(6 * DIAMETER, thickness=4 * DIAMETER)}
each_box = pytest.mark.parametrize("box", BOXES.values(), ids=BOXES)
SILOS = (silo.DISCS, silo.SLAB, silo.ROUGH_SLAB)
each_silo = pytest.mark.parametrize("one", SILOS, ids=[one.kind for one in SILOS])


def failed(rows):
    return [row.quantity for row in rows if not row.passed]


@pytest.mark.slow
@pytest.mark.parametrize("name", suite.SLOW)
def test_slow_case(name):
    start_taichi()
    assert not failed(suite.SLOW[name](lambda done, total: None))


@each_box
def test_grains_are_dropped_apart_and_inside_the_box(box):
    grains = box.lattice(200, seed=1, bottom=0.1)
    assert len(cKDTree(grains.position.T).query_pairs(2 * grains.radius.max())) == 0
    room = (box.width, 1.0) if box.thickness is None else (box.width, box.thickness, 1.0)
    for place, length in zip(grains.position, room, strict=True):
        assert (place - grains.radius >= 0).all()
        assert (place + grains.radius <= length).all()
    assert grains.position[-1].min() >= 0.1


@each_box
def test_forces_from_the_law_are_those_that_move_the_grains(box):
    start_taichi()
    rough = law(
        restitution=0.5, friction=0.5, wall_friction=0.3, glass_friction=0.2, stiffness=box.stiffness(1e5)
    )
    loose = box.lattice(80, seed=3)
    solver = replace(box.solver(loose, rough), time_step=2e-6)
    advance_for(solver, 0.06)
    forces, before = contact_forces(solver), solver.read_grains()
    solver.advance(1)
    change = (solver.read_grains().velocity - before.velocity) * before.mass / solver.time_step
    change[-1] += before.mass * GRAVITY
    expected = total(forces, before.count)
    expected = expected if box.thickness else expected[[0, 2]]
    assert forces.pairs.shape[1] > 50
    assert (forces.from_walls != 0).any(axis=(1, 2)).all()
    assert change == pytest.approx(expected, abs=5e-3 * np.abs(expected).max())


def total(forces, count):
    """Of all contacts on every grain, N, shape (3, count)."""
    sum_of = forces.from_walls.sum(axis=0)
    for axis in range(3):
        for grain, sign in zip(forces.pairs, (1, -1), strict=True):
            sum_of[axis] += np.bincount(grain, sign * forces.on_first[axis], minlength=count)
    return sum_of


def stresses_after_janssen(one, *, ratio=0.6, friction=0.3, bulk_weight=12e3):
    """What a silo that follows the law exactly would show, by the balance of forces on its rectangle."""
    perimeter = sum(2 * pair.length for pair in one.walls.values())
    saturation = bulk_weight * one.section / (perimeter * friction * ratio)
    hydrostatic = np.linspace(4 * saturation, 0, 41)
    vertical = saturation * (1 - np.exp(-hydrostatic / saturation))
    middle = (hydrostatic > saturation) & (hydrostatic < 3 * saturation)
    pressure = ratio * float(vertical[middle].mean())
    return silo.Stresses(
        hydrostatic,
        vertical,
        dict.fromkeys(one.walls, pressure),
        dict.fromkeys(one.walls, friction * pressure),
        middle,
        float(vertical[0]),
        bulk_weight,
    )


@each_silo
def test_a_silo_after_janssen_passes(one):
    rows = silo.compare_with_janssen(one, stresses_after_janssen(one))
    assert not failed(rows)
    assert all(row.relative_error < 1e-6 for row in rows if "S" in row.quantity.split())


@each_silo
def test_a_silo_whose_walls_carry_nothing_is_found_out(one):
    right = stresses_after_janssen(one)
    wrong = replace(right, vertical=right.hydrostatic, base=float(right.hydrostatic[0]))
    assert len(failed(silo.compare_with_janssen(one, wrong))) >= 3


def test_glass_that_carries_counts_in_the_silo():
    """A slab saturated by its glass is not taken for one that its end walls alone saturate."""
    rough = stresses_after_janssen(silo.ROUGH_SLAB)
    names = ("wall",)
    without_glass = replace(
        rough,
        pressure={name: rough.pressure[name] for name in names},
        shear={name: rough.shear[name] for name in names},
    )
    assert any("S, fitted" in name for name in failed(silo.compare_with_janssen(silo.SLAB, without_glass)))


def power_law(collapse, factor, exponent):
    return {ratio: factor * ratio**exponent for ratio in (*collapse.low, *collapse.high)}


def test_run_outs_of_a_channel_pass_where_they_are_as_published():
    slab = column_collapse.SLAB
    low, high = power_law(slab, 1.2, 1.0), power_law(slab, 1.9, 2 / 3)
    published = {ratio: (low if ratio in slab.low else high)[ratio] for ratio in low}
    assert not failed(column_collapse.compare_run_outs(slab, published))
    (wrong,) = failed(column_collapse.compare_run_outs(slab, low))
    assert wrong.startswith("exponent")
    short = {ratio: value / 2 for ratio, value in published.items()}
    assert len(failed(column_collapse.compare_run_outs(slab, short))) == 2


@pytest.mark.parametrize("ledge", [repose.DISCS, repose.SLAB], ids=["discs", "slab"])
@pytest.mark.parametrize("degrees", [15.0, 30.0])
def test_slope_of_a_wedge(ledge, degrees):
    rng = np.random.default_rng(1)
    x, z = rng.uniform(0, 1, (2, 20_000)) * [[ledge.bed.width], [ledge.bed.width]]
    below = z < (ledge.bed.width - x) * np.tan(np.radians(degrees))
    places = np.stack([x, z])[:, below]
    if ledge.bed.thickness:
        places = np.insert(places, 1, rng.uniform(0, ledge.bed.thickness, below.sum()), axis=0)
    kind = Spheres if ledge.bed.thickness else Grains
    wedge = moved(kind.at_rest(places, np.full(below.sum(), 1e-3), 1.0), z=ledge.drop)
    assert repose.slope(ledge, wedge) == pytest.approx(degrees, abs=1.5)


def test_a_weak_sample_is_found_out():
    weak, strong = (biaxial.CriticalState(across, 1000.0) for across in (1235.0, 1600.0))  # sine 0.105, 0.23
    assert len(failed(biaxial.compare_critical_states(biaxial.SLAB, [weak], [strong]))) == 2
