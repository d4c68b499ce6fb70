from types import SimpleNamespace

import numpy as np
import pytest

from synth.camera.motion import Carried, Interpolated
from synth.camera.particle_field import ParticleField
from synth.camera.soil_region import first_region
from synth.camera.texture import strew


def carried(field, x, z):
    """Where a field carries points to, their turn, the nearest particle and the strain there."""
    moved = field.carry(x, z, np.zeros(len(x)), np.ones(len(x), np.uint8))
    particle, strain = field.look_around(x, z, *2 * [np.arange(len(x), dtype=np.int32)])
    assert np.array_equal(moved.alive == 1, particle >= 0)
    return SimpleNamespace(**vars(moved), particle=particle, strain=strain)


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


def test_a_field_around_points_is_the_same_as_one_of_all_particles(cases, taichi):
    generator = np.random.default_rng(9)
    case = cases.case(lambda x, z, k: (x + k * generator.normal(0, 2e-4, x.shape), z))
    points = cases.centre[0] + generator.uniform(-4e-3, 4e-3, 500), np.full(500, cases.centre[1])
    whole = carried(ParticleField(case.recording, 0, 1, case.scene), *points)
    part = carried(ParticleField(case.recording, 0, 1, case.scene, around=points), *points)
    for name in ("x", "z", "angle", "strain"):
        assert np.allclose(getattr(part, name), getattr(whole, name), rtol=1e-9, atol=1e-12)
    assert np.array_equal(part.particle, whole.particle)


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
    owner = motion.surroundings(start, 1, *2 * [np.arange(grains.count, dtype=np.int32)]).particle
    after = motion.advance(start)
    square = (grains.x[:, None][:2000] - x) ** 2 + (grains.z[:, None][:2000] - z) ** 2
    assert np.array_equal(owner[:2000], square.argmin(axis=1))
    turn = (angle[1] - angle[0])[owner]
    assert np.allclose(after.angle, turn)
    before = (grains.x - x[owner]) + 1j * (grains.z - z[owner])
    now = (after.x - next_x[owner]) + 1j * (after.z - next_z[owner])
    assert np.abs(now - before * np.exp(1j * turn)).max() < 1e-12


def test_a_lone_particle_that_falls_in_a_pore_moves_no_soil(cases, fields, taichi):
    x, z = cases.lattice()
    lone = np.hypot(x - cases.centre[0], z - cases.centre[1]).argmin()
    fallen = z.copy()
    fallen[lone] -= 0.4e-3  # 2 px, of a particle of 10 px
    field = ParticleField(cases.recording([x, x], [z, fallen]), 0, 1, cases.scene())
    assert np.flatnonzero(field.loose).tolist() == [lone]
    around = np.linspace(-3e-3, 3e-3, 41)
    at_x, at_z = (axis.ravel() for axis in np.meshgrid(x[lone] + around, z[lone] + around))
    moved = carried(field, at_x, at_z)
    assert np.hypot(moved.x - at_x, moved.z - at_z).max() < 0.01 * cases.pixel


@pytest.mark.parametrize("name", ["slip line", "shaken", "rotation", "edge"])
def test_particles_of_a_flow_are_not_loose(cases, fields, taichi, name):
    generator = np.random.default_rng(11)
    field = {
        "slip line": lambda x, z, k: (x + k * 1e-3 * (z > cases.centre[1]), z),
        "shaken": lambda x, z, k: (x + k * generator.normal(0, 2e-4, x.shape), z),
        "rotation": fields["rotation"](0.1),
        "edge": lambda x, z, k: (x, z - k * 1e-3 * (x > cases.centre[0] + 0.028)),
    }[name]
    case = cases.case(field)
    loose = ParticleField(case.recording, 0, 1, case.scene).loose
    assert loose.mean() < 0.01


def test_soil_on_both_sides_of_a_thin_blade_keeps_its_own_motion(cases, taichi):
    """Soil above the bucket's blade is pushed, soil below it rests."""
    scene = cases.scene(name="bucket")
    half, angle = scene.implement.thickness / 2, np.deg2rad(scene.implement.cut_angle)
    edge = cases.centre[0] + 0.02, cases.centre[1] - 0.012
    x, z = cases.lattice()
    above = lambda px, pz: (pz - edge[1] - half) + np.tan(angle) * (px - edge[0])  # noqa: E731
    off = np.abs(above(x, z)) * np.cos(angle) > half + 1e-3  # particles of 1 mm radius touch the blade
    x, z = x[off], z[off]
    push = 1e-3 * (above(x, z) > 0)
    recording = cases.recording([x, x + push], [z, z], implement=edge)
    along = np.linspace(0.012, 0.03, 200)[:, None]
    beside = np.array([-half - 1e-3, -half - 0.1e-3, half + 0.1e-3, half + 1e-3])
    at_x = (edge[0] - along * np.cos(angle) + beside * np.sin(angle)).ravel()
    at_z = (edge[1] + half + along * np.sin(angle) + beside * np.cos(angle)).ravel()
    moved = carried(ParticleField(recording, 0, 1, scene), at_x, at_z)
    expected = 1e-3 * (above(at_x, at_z) > 0)
    assert (moved.particle >= 0).all()
    assert np.abs(moved.x - at_x - expected).max() < 1e-9
    assert np.abs(moved.z - at_z).max() < 1e-9


def test_the_face_turns_with_its_grain_and_its_albedo_stays(taichi):
    from synth.camera import light_kernels

    first, grain, place = np.array([0, 1], np.int32), np.zeros(1, np.int32), np.full((1, 3), 9, np.float32)
    looks = [np.array([value], np.float32) for value in (0.3, 0.0, 0.5)]
    samples, behind = np.zeros((1, 1, 1, 16), np.int32), np.zeros((1, 1), np.float32)
    faces, lights = [], []
    for turn in (0.0, np.pi / 2):
        face, light = np.empty((1, 8), np.float32), np.empty((4, 1, 4), np.float32)
        light_kernels.grain_radiance(4)(
            *(first, 1, grain, place, 32, 1, np.array([turn]), *looks),
            *(1.4, 0.25, 0.0, 0.75 * 0.8, 0.75 * 0.6, behind, samples, face, light),
        )
        faces.append(face[0])
        lights.append(light)
    assert faces[0][3:6] == pytest.approx([0.3, 0.0, 1.4 * 0.5])
    # Counter-clockwise takes what leans to the right upwards, which is against y of the picture.
    assert faces[1][3:6] == pytest.approx([0.0, -0.3, 1.4 * 0.5], abs=1e-6)
    # A flat grain that leans by 0.3, up or to the right, lit by both lamps: see `_light_of_group`.
    front = 1 + light_kernels.RIM
    both_lamps = 2 * front * 0.6 / np.hypot(front, 0.3)
    assert lights[1] == pytest.approx(1.4 * 0.5 * (0.25 + 0.75 * both_lamps), rel=1e-5)
    assert lights[0] == pytest.approx(lights[1], rel=1e-5)
