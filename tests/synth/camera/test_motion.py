import numpy as np
import pytest

from synth.camera.motion import Carried, Interpolated
from synth.camera.particle_field import ParticleField
from synth.camera.soil_region import first_region
from synth.camera.texture import strew


def carried(field, x, z):
    """Displacement (point, 2), turn and strain of points that a field carries."""
    return field.carry(x, z, np.zeros(len(x)), np.ones(len(x), np.uint8))


@pytest.fixture(scope="module")
def points(cases):
    generator = np.random.default_rng(5)
    x = cases.centre[0] + generator.uniform(-0.02, 0.02, 5000)
    z = cases.centre[1] + generator.uniform(-0.015, 0.015, 5000)
    return x, z


def move(matrix, shift, centre):
    matrix = np.array(matrix)

    def field(x, z, frame):
        off = np.stack([x - centre[0], z - centre[1]])
        moved = frame * (matrix @ off + np.array(shift)[:, None])
        return x + moved[0], z + moved[1]

    return field


def test_an_affine_field_is_met_exactly(cases, points, taichi):
    field = move([[0.03, -0.08], [0.11, -0.02]], (1e-3, -2e-3), cases.centre)
    case = cases.case(field)
    moved = carried(ParticleField(case.recording, 0, 1, case.scene), *points)
    x, z = points
    expected_x, expected_z = field(x, z, 1)
    assert np.abs(moved.x - expected_x).max() < 1e-12
    assert np.abs(moved.z - expected_z).max() < 1e-12
    assert moved.strain == pytest.approx(np.hypot(0.05, 0.03), rel=1e-5)


@pytest.mark.parametrize("angle", [-0.4, 0.02])
def test_a_rigid_rotation_turns_by_its_angle_and_does_not_strain(cases, fields, points, taichi, angle):
    case = cases.case(fields["rotation"](angle))
    moved = carried(ParticleField(case.recording, 0, 1, case.scene), *points)
    assert np.abs(moved.angle - angle).max() < 1e-12
    assert moved.strain.max() < 1e-6


def test_simple_shear_strains_by_gamma_and_turns_by_half_of_it(cases, fields, points, taichi):
    case = cases.case(fields["shear"](0.01))
    moved = carried(ParticleField(case.recording, 0, 1, case.scene), *points)
    assert moved.strain == pytest.approx(0.01, rel=1e-5)
    assert moved.angle == pytest.approx(-0.005, rel=1e-3)  # the upper part moves right: clockwise


def test_the_field_is_smooth(cases, taichi):
    generator = np.random.default_rng(6)
    shake = lambda x, z, frame: (x + frame * generator.normal(0, 1e-3, x.shape), z)  # noqa: E731
    count, step = 20_001, 1e-6
    x = cases.centre[0] + step * (np.arange(count) - count // 2)
    case = cases.case(shake)
    moved = carried(ParticleField(case.recording, 0, 1, case.scene), x, np.full(count, cases.centre[1]))
    slope = np.diff(moved.x - x) / step
    assert np.abs(slope).max() < 10  # of displacements of 1 mm over particles of 2 mm
    assert np.abs(np.diff(slope)).max() < 0.02  # no kinks, so C1


def test_few_or_collinear_neighbours_do_not_blow_up(cases, taichi):
    x = np.array([0.2, 0.202, 0.204, 0.3])
    z = np.array([0.1, 0.1, 0.1, 0.1])
    recording = cases.recording(
        [x, x + np.array([0, 1e-4, 2e-4, 0])], [z, z + np.array([0, 1e-4, -1e-4, 1e-3])]
    )
    at_x, at_z = np.linspace(0.199, 0.205, 50), np.full(50, 0.1012)
    moved = carried(ParticleField(recording, 0, 1, cases.scene()), at_x, at_z)
    assert (moved.particle >= 0).all()
    assert np.hypot(moved.x - at_x, moved.z - at_z).max() < 5e-4


def test_a_grain_without_a_particle_near_is_lost(cases, fields, taichi):
    case = cases.case(fields["rest"])
    grains = strew(case.scene, first_region(case.recording, case.scene))
    x, z = cases.lattice()
    gone = np.where(x < cases.centre[0], x, x + 0.5)
    recording = cases.recording([x, gone, gone], [z, z, z])
    motion = Interpolated(recording, grains, case.scene)
    after = motion.advance(motion.advance(motion.start()))
    left = grains.x < cases.centre[0] - 5e-3
    assert after.alive[left].all()
    torn = np.abs(grains.x - cases.centre[0]) < 0.5e-3
    assert not after.alive[torn].all()


def test_carried_grains_are_rigid_with_their_particle(cases, taichi):
    x, z = cases.lattice()
    generator = np.random.default_rng(7)
    angle = generator.normal(0, 0.3, (2, len(x)))
    next_x, next_z = x + generator.normal(0, 1e-3, len(x)), z + generator.normal(0, 1e-3, len(x))
    recording = cases.recording([x, next_x], [z, next_z], angle=angle)
    grains = strew(cases.scene(), first_region(recording, cases.scene()))
    motion = Carried(recording, grains, cases.scene())
    start = motion.start()
    owner = motion.surroundings(start, 1).particle
    after = motion.advance(start)
    square = (grains.x[:, None][:2000] - x) ** 2 + (grains.z[:, None][:2000] - z) ** 2
    assert np.array_equal(owner[:2000], square.argmin(axis=1))
    turn = (angle[1] - angle[0])[owner]
    assert np.allclose(after.angle, turn)
    before = (grains.x - x[owner]) + 1j * (grains.z - z[owner])
    now = (after.x - next_x[owner]) + 1j * (after.z - next_z[owner])
    assert np.abs(now - before * np.exp(1j * turn)).max() < 1e-12
