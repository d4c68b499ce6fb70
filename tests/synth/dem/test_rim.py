"""A wheel with an elastic rim among grains: balances, a flat floor, the rigid limit, what is recorded."""

import csv
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from synth import load_scene, simulate
from synth.dem.contact_law import ContactLaw, damping_ratio_of, largest_time_step
from synth.dem.grains import Grains
from synth.dem.rim import contact_extent, rim_state
from synth.dem.tool import Tool
from synth.devices import start_taichi
from synth.implements.compliant_wheel import rim_shape
from synth.implements.ring import Ring, rest_on_floor, stiffened
from synth.scene import SceneError, parse_scene
from tests.synth.implements.ring_energy import elastic_energy

start_taichi()

from synth.dem.solver import Solver  # noqa: E402 - taichi must be started first

STIFFNESS, DENSITY = 1e6, 2000.0
RING = Ring(
    node_count=64,
    node_radius=0.038,
    half_thickness=0.002,
    node_mass=0.05,
    radial_stiffness=4000.0,
    tangential_stiffness=2000.0,
    damping=0.0,
    hoop_stiffness=1e6,
    bending_stiffness=2.0,
)


def wheel(ring=RING, **changes) -> Tool:
    return Tool(rim_shape(ring.unloaded, ring.half_thickness), x=0.5, z=0.5, ring=ring, **changes)


def solver_of(grains, tool, *, law=None, steps_per_contact=100, width=1.0) -> Solver:
    smooth = ContactLaw(STIFFNESS, 0.5 * STIFFNESS, 0.0, 0.0, 0.0, 0.0, 0.0)
    step = largest_time_step(grains.mass, STIFFNESS, steps_per_contact)
    return Solver(grains, law or smooth, width, step, gravity=(0.0, 0.0), tool=tool)


def falling_cloud() -> Grains:
    """Grains above the wheel and to one side of its axle, on their way down and to the right."""
    rng = np.random.default_rng(5)
    x, z = np.meshgrid(np.arange(8) * 2.3e-3 + 0.49, np.arange(4) * 2.3e-3 + 0.5415)
    grains = Grains.at_rest(np.stack([x.ravel(), z.ravel()]), 1e-3 * rng.uniform(0.8, 1.2, x.size), DENSITY)
    return replace(grains, velocity=np.tile([[0.1], [-0.3]], x.size))


def momenta(mass, offset, velocity) -> np.ndarray:
    """Momentum along x and z, and angular momentum about the origin of `offset` (n, 2)."""
    along = (mass * velocity.T).sum(axis=1)
    turning = (mass * (offset[:, 0] * velocity[:, 1] - offset[:, 1] * velocity[:, 0])).sum()
    return np.array([*along, turning])


def test_momentum_that_grains_lose_goes_into_rim_and_hub():
    grains, rough = falling_cloud(), ContactLaw(STIFFNESS, 5e5, damping_ratio_of(0.6), 0.4, 0.0, 0.4, 0.1)
    solver = solver_of(grains, wheel(replace(RING, damping=0.3), spin=-2.0), law=rough, steps_per_contact=50)
    tool = solver.read_tool()
    before = momenta(RING.node_mass, tool.nodes - (0.5, 0.5), tool.node_velocity)
    solver.advance(round(0.03 / solver.time_step))
    given, hub, after, tool = (
        solver.take_tool_impulse(),
        solver.hub_impulse(),
        solver.read_grains(),
        solver.read_tool(),
    )
    given = np.array([given.x, given.z, given.moment])
    lost = -momenta(grains.mass, after.position.T - (0.5, 0.5), after.velocity.T)
    lost += momenta(grains.mass, grains.position.T - (0.5, 0.5), grains.velocity.T)
    lost[2] -= (after.inertia * after.spin).sum()
    rim = momenta(RING.node_mass, tool.nodes - (0.5, 0.5), tool.node_velocity) - before
    assert abs(given[1]) > 0.1 * 0.3 * grains.mass.sum()
    np.testing.assert_allclose(given, lost, rtol=1e-9)
    np.testing.assert_allclose(rim + np.array([hub.x, hub.z, hub.moment]), given, rtol=1e-9)


def test_a_load_falls_with_the_hub_and_the_rim_that_hangs_on_it():
    """Nothing touches: load / (hub + rim) is the acceleration of the centre of mass."""
    grains = Grains.at_rest(np.array([[0.1], [0.1]]), np.array([1e-3]), DENSITY)
    solver = solver_of(grains, wheel(replace(RING, damping=1.0), mass=3.0, load=50.0, heaves=True))
    solver.advance(4000)
    tool = solver.read_tool()
    momentum = 3.0 * tool.velocity_z + RING.node_mass * tool.node_velocity[:, 1].sum()
    assert momentum == pytest.approx(-50.0 * solver.time, rel=1e-9)


def test_energy_of_an_elastic_rim_that_grains_bounce_off():
    grains = falling_cloud()  # which are apart, unlike those of the test above
    grains = replace(grains, position=grains.position + 0.15 * (grains.position - [[0.498], [0.5415]]))
    solver = solver_of(grains, wheel())
    assert solver.contacts()[0].size == 0
    start = 0.5 * (grains.mass * (grains.velocity**2).sum(axis=0)).sum()
    solver.advance(round(0.06 / solver.time_step))
    tool, after = solver.read_tool(), solver.read_grains()
    offset = after.position.T - (tool.x, tool.z)
    assert contact_extent(tool.section, offset, after.radius) == (0.0, 0.0)
    assert solver.contacts()[0].size == 0
    in_grains = 0.5 * (after.mass * (after.velocity**2).sum(axis=0)).sum()
    moving = 0.5 * RING.node_mass * (tool.node_velocity**2).sum()
    in_rim = moving + elastic_energy(RING, tool.nodes - (0.5, 0.5))
    assert in_rim > 0.02 * start
    assert in_grains + in_rim == pytest.approx(start, rel=0.01)


def test_a_wheel_put_down_on_a_flat_floor_flattens_as_its_rest_says():
    deflection, load = 0.008, 300.0
    ring = stiffened(RING, deflection, load)
    ring = replace(ring, damping=2 * np.sqrt(ring.radial_stiffness * ring.node_mass))
    count, radius = 60, 1e-3
    floor = np.stack([0.44 + 0.12 / count * (np.arange(count) + 0.5), np.full(count, radius)])
    grains = Grains.at_rest(floor - [[0.44], [0.0]], np.full(count, radius), 2e4)
    tool = replace(wheel(ring), x=0.06, z=2 * radius + 0.0401, mass=1.0, load=load, heaves=True)
    solver = solver_of(grains, tool, steps_per_contact=20, width=0.12)
    assert solver.time_step < ring.largest_time_step(6 * STIFFNESS)
    for share in np.linspace(0.02, 1.0, 50):
        solver.drive_tool(velocity_x=0.0, velocity_z=0.0, spin=0.0, load=share * load)
        solver.advance(round(4e-3 / solver.time_step))
    solver.take_tool_impulse()
    time = solver.time
    solver.advance(round(0.1 / solver.time_step))
    rest, tool = rest_on_floor(ring, deflection), solver.read_tool()
    grains = solver.read_grains()
    state, upward = rim_state(tool, grains), solver.take_tool_impulse().z
    assert upward / (solver.time - time) == pytest.approx(load, rel=0.02)
    assert state.deflection == pytest.approx(deflection, rel=0.03)
    assert 2 * radius + 0.04 - tool.z == pytest.approx(deflection, rel=0.04)  # the floor gives way a little
    touching = rest.nodes[:, 1] < -(0.04 - deflection - ring.half_thickness) + 1e-5
    assert state.contact_length == pytest.approx(np.ptp(rest.nodes[touching, 0]), abs=2 * ring.bar_length)
    np.testing.assert_allclose(tool.nodes - (tool.x, tool.z), rest.nodes, atol=0.05 * deflection)


@pytest.fixture(scope="module")
def recording(tiny_rim):
    return simulate(tiny_rim)


def test_the_rim_flattens_and_carries_the_load(tiny_rim, recording):
    data = recording.data.where(recording.data.sample_time > 0, drop=True)
    assert float(data.force_z.mean()) == pytest.approx(tiny_rim.implement.normal_load, rel=0.2)
    assert 0.2 * 0.005 < float(data.deflection.mean()) < 1.2 * 0.005
    assert 0.3 * 0.03 < float(data.contact_length.mean()) < 0.06
    # the middle of a rim that hardly stretches, and flattens, is nearer to the axle than the surface
    assert 0.8 * 0.03 < float(data.rolling_radius.mean()) < 0.03
    assert float(data.slip.mean()) == pytest.approx(tiny_rim.drive.slip, rel=1e-3)  # by the unloaded radius


def test_rim_in_the_recording_is_the_rim_that_deflects(recording):
    data = recording.data
    assert data.sizes["node"] == 60
    last = int(np.argmin(np.abs(data.sample_time.values - data.time.values[-1])))
    lowest = data.implement_z.values[-1] - data.rim_z.values[-1].min() + 1e-3
    assert 0.03 - lowest == pytest.approx(float(data.deflection[last]), abs=1e-9)


def test_forces_csv_has_the_columns_of_every_wheel_first(tmp_path, recording):
    recording.write_forces(tmp_path / "forces.csv")
    header, *lines = csv.reader((tmp_path / "forces.csv").read_text().splitlines())
    assert header == [
        "time [s]", "travel [m]", "slip [1]", "sinkage [m]", "force_x [N]", "force_z [N]", "torque [N m]",
        "deflection [m]", "contact_length [m]", "rolling_radius [m]",
    ]  # fmt: skip
    assert len(lines) == recording.data.sizes["sample"]


def test_a_stiff_rim_is_a_rigid_wheel(tiny_wheel, tiny_rim, tiny_recording):
    tables = tiny_rim.to_dict()
    tables["implement"] |= {"deflection": 5e-5, "bending_stiffness": 1.0, "rim_mass": 0.3}
    stiff, rigid = simulate(parse_scene(tables)).data, tiny_recording.data
    load = tiny_wheel.implement.normal_load
    for data in (stiff, rigid):
        assert float(data.force_z.where(data.sample_time > 0).mean()) == pytest.approx(load, rel=0.15)
    sinkage, force = (
        [float(data[name].where(data.sample_time > 0).mean()) for data in (stiff, rigid)]
        for name in ("sinkage", "force_x")
    )
    # Grains soon lie elsewhere: two runs of so few are alike to a part of a grain only.
    assert sinkage[0] == pytest.approx(sinkage[1], abs=0.5 * tiny_wheel.bed.grain_diameter)
    assert force[0] == pytest.approx(force[1], abs=0.1 * load)


def test_saved_state_goes_on_bit_by_bit():
    def fresh() -> Solver:
        return solver_of(falling_cloud(), wheel(mass=3.0, load=20.0, heaves=True))

    solver, resumed = fresh(), fresh()
    solver.advance(3000)
    state = solver.save_state()
    solver.advance(3000)
    resumed.restore_state(state)
    resumed.advance(3000)
    one, other = solver.save_state(), resumed.save_state()
    assert not np.array_equal(one["rim"], state["rim"])
    for name, array in one.items():
        np.testing.assert_array_equal(other[name], array, err_msg=name)


@pytest.mark.slow
def test_same_bytes_on_one_and_two_threads(tmp_path, tiny_rim, recording):
    scene = tmp_path / "scene.toml"
    scene.write_text(tiny_rim.to_toml())
    program = (
        "import sys; from synth import load_scene, simulate; "
        "print(simulate(load_scene(sys.argv[1]), threads=int(sys.argv[2])).digest)"
    )
    for threads in (1, 2):
        run = [sys.executable, "-c", program, scene, str(threads)]
        output = subprocess.run(run, capture_output=True, text=True, check=True).stdout
        assert output.strip() == recording.digest


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"rim_mass": 1e-4}, r"implement.rim_mass = 0.0001 kg: the rim needs steps of at most"),
        ({"deflection": 0.06}, r"deflection = 0.06 m: below half of radius = 0.114 m is allowed"),
        ({"rim_thickness": 0.0}, r"implement.rim_thickness = 0.0: "),
    ],
)
def test_rims_that_cannot_be_are_refused(changes, complaint):
    tables = load_scene("compliant_wheel").to_dict()
    tables["implement"] |= changes
    with pytest.raises(SceneError, match=complaint):
        parse_scene(tables)
