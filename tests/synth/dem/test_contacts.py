"""The forces between grains that a recording keeps are those that hold the grains up."""

import numpy as np
import pytest

from synth import Recording, simulate
from synth.dem import checkpoint
from synth.dem.bed import contact_law, settled_bed
from synth.dem.contact_law import largest_time_step
from synth.dem.contacts import Contacts
from synth.devices import start_taichi


@pytest.fixture(scope="module")
def scene(tiny_wheel_with_contacts):
    return tiny_wheel_with_contacts


@pytest.fixture(scope="module")
def recording(tiny_recording_with_contacts):
    return tiny_recording_with_contacts


def test_forces_are_split_along_normal_and_tangent():
    """The second grain lies up right of the first: it pushes it down left, and turns it up left."""
    position = np.array([[0.0, 3.0, 9.0], [0.0, 4.0, 9.0]])
    pairs = np.array([[0, 0], [1, 2]], np.int32)
    push, shear = np.array([0.6, 0.8]), np.array([-0.8, 0.6])
    contacts = Contacts.of_forces(position, pairs, np.stack([-5 * push + 2 * shear, 0 * push]))
    np.testing.assert_array_equal(contacts.pairs, [[0], [1]])
    np.testing.assert_allclose([contacts.normal[0], contacts.tangential[0]], [5, 2])


def force_on_grains(contacts, position):
    """Sum of the forces on every grain, N/m, shape (2, N)."""
    first, second = contacts.pairs
    branch = position[:, second] - position[:, first]
    normal = branch / np.hypot(*branch)
    tangent = np.stack([-normal[1], normal[0]])
    on_second = contacts.normal * normal - contacts.tangential * tangent
    total = np.zeros_like(position)
    for axis in range(2):
        np.add.at(total[axis], second, on_second[axis])
        np.subtract.at(total[axis], first, on_second[axis])
    return total


def test_they_hold_grains_at_rest_up(scene):
    """Clear of the walls, the forces on a grain make up for its weight."""
    start_taichi()
    from synth.dem.solver import Solver

    grains, law = settled_bed(scene).grains, contact_law(scene)
    step = largest_time_step(grains.mass, law.normal_stiffness, 20)
    solver = Solver(grains, law, scene.bed.width, step, drag=200.0)
    assert solver.pair_forces().normal.size == 0
    solver.advance(60_000)
    (x, z), margin = solver.read_grains().position, scene.bed.grain_diameter
    clear = (x > margin) & (x < scene.bed.width - margin) & (z > margin)
    force = force_on_grains(solver.pair_forces(), solver.read_grains().position)[:, clear]
    weight = grains.mass[clear] * scene.bed.gravity
    assert clear.sum() > 200
    np.testing.assert_allclose(force[1] / weight, 1, atol=0.02)
    np.testing.assert_allclose(force[0] / weight, 0, atol=0.02)


def test_they_are_within_the_friction_and_between_grains_that_touch(scene, recording):
    data = recording.data
    assert data.contact_count.values.min() > 0.7 * data.sizes["particle"]
    assert data.contact_count.values.sum() == data.sizes["contact"]
    friction = scene.soil.contact.friction * data.contact_normal_force.values
    assert (np.abs(data.contact_tangential_force.values) <= friction * (1 + 1e-9)).all()
    contacts, state = recording.contacts(1), data.isel(frame=1)
    i, j = contacts.contact_first.values, contacts.contact_second.values
    distance = np.hypot(*(state[f"position_{a}"].values[i] - state[f"position_{a}"].values[j] for a in "xz"))
    gap = distance - (data.radius.values[i] + data.radius.values[j])
    assert gap.max() < 1e-3 * scene.bed.grain_diameter


def test_they_change_nothing_else_and_are_read_back(tmp_path, recording, tiny_recording):
    plain = tiny_recording
    assert "contact_count" not in plain.data and plain.contacts(0) is None
    for name in plain.data:
        np.testing.assert_array_equal(plain.data[name], recording.data[name])
    recording.write(tmp_path / "recording.nc")
    again = Recording.read(tmp_path / "recording.nc")
    assert again.digest == recording.digest != plain.digest
    assert again.data.contact_normal_force.attrs["units"] == "N m-1"


class StoppedError(Exception):
    pass


def test_a_run_that_goes_on_has_the_same(tmp_path, scene, recording, monkeypatch):
    def stop(done, total):
        if done >= 0.97 * total:
            raise StoppedError

    monkeypatch.setattr(checkpoint, "CHECKPOINT_INTERVAL", 0.0)
    with pytest.raises(StoppedError):
        simulate(scene, checkpoint=tmp_path / "checkpoint", progress=stop)
    said = []
    again = simulate(scene, checkpoint=tmp_path / "checkpoint", say=said.append)
    assert "goes on after" in said[0]
    assert again.digest == recording.digest
