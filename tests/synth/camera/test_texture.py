import numpy as np
import pytest
from scipy.special import ndtr

from synth.camera.patches import patch_field
from synth.camera.soil_region import first_region
from synth.camera.texture import DEEPEST, draw_diameters, drawn_sizes, mean_grain_area, strew, tone_behind


@pytest.fixture(scope="module")
def rest(cases, fields, taichi):
    return cases.case(fields["rest"])


@pytest.fixture(scope="module")
def grains(rest):
    return strew(rest.scene, first_region(rest.recording, rest.scene))


def test_area_fractions_follow_the_distribution_by_mass(rest):
    sizes = rest.scene.soil.grain_sizes
    diameter = draw_diameters(sizes, 1_000_000, np.random.default_rng(1))
    assert diameter.min() >= sizes.smallest
    assert diameter.max() <= sizes.largest
    by_mass = lambda d: ndtr(np.log(d / sizes.median) / sizes.log_deviation)  # noqa: E731
    low, high = by_mass(sizes.smallest), by_mass(sizes.largest)
    for limit in (0.1e-3, 0.2e-3, 0.3e-3, 0.5e-3, 1.0e-3):
        finer = np.sum(diameter[diameter < limit] ** 2) / np.sum(diameter**2)
        assert finer == pytest.approx((by_mass(limit) - low) / (high - low), abs=0.01)


def test_the_mean_area_is_that_of_the_drawn_grains(rest):
    sizes = rest.scene.soil.grain_sizes
    drawn = draw_diameters(sizes, 1_000_000, np.random.default_rng(2))
    assert mean_grain_area(sizes) == pytest.approx(np.pi / 4 * np.mean(drawn**2), rel=0.01)


def test_the_grains_cover_the_soil_as_often_as_asked(rest, grains):
    region = first_region(rest.recording, rest.scene)
    soil = region.mask.sum() * rest.scene.camera.metres_per_pixel**2
    covered = np.pi / 4 * np.sum(grains.diameter**2)
    assert covered / soil == pytest.approx(rest.scene.texture.coverage, rel=0.03)


def test_depths_are_uniform(grains):
    assert grains.depth.min() >= 0
    assert np.histogram(grains.depth / DEEPEST, 4, (0, 1))[0] == pytest.approx(grains.count / 4, rel=0.05)


def test_the_seed_alone_decides(rest, grains):
    again = strew(rest.scene, first_region(rest.recording, rest.scene))
    other = strew(rest.scene.model_copy(update={"seed": 1}), first_region(rest.recording, rest.scene))
    assert np.array_equal(grains.x, again.x)
    assert np.array_equal(grains.brightness, again.brightness)
    assert not np.array_equal(grains.x[:100], other.x[:100])


def test_deeper_grains_are_darker(rest):
    light = rest.scene.light.model_copy(update={"shade": 0.3})
    scene = rest.scene.model_copy(update={"light": light})
    grains = strew(scene, first_region(rest.recording, scene))
    front = grains.brightness[grains.depth < DEEPEST // 10].mean()
    back = grains.brightness[grains.depth > DEEPEST // 10 * 9].mean()
    assert back < 0.8 * front


def test_pores_between_particles_are_soil_and_the_air_above_is_not(cases, taichi):
    x, z = cases.lattice()
    below = z < cases.centre[1]
    recording = cases.recording([x[below]] * 2, [z[below]] * 2, radius=0.8e-3)
    region = first_region(recording, cases.scene())
    inside = np.linspace(-0.01, 0.01, 200) + cases.centre[0]
    assert region.contains(inside, np.full(200, cases.centre[1] - 0.006)).all()
    assert not region.contains(inside, np.full(200, cases.centre[1] + 0.0025)).any()


def test_soil_finer_than_the_particles_has_a_smooth_surface_in_their_middle(cases, taichi):
    x, z = cases.lattice()
    below = z < cases.centre[1] + np.random.default_rng(4).uniform(-0.5e-3, 0.5e-3, len(z))
    recording = cases.recording([x[below]] * 2, [z[below]] * 2)
    surface = {}
    for motion in ("interpolated", "carried"):
        region = first_region(recording, cases.scene(texture={"motion": motion}))
        surface[motion] = region.mask[:, 60:-60].sum(axis=0)  # the ends of the heap slope
    along = np.arange(len(surface["carried"]))
    bumps = {
        motion: np.std(height - np.polyval(np.polyfit(along, height, 3), along))
        for motion, height in surface.items()
    }
    assert bumps["carried"] > 1  # px; particles have 10
    assert bumps["interpolated"] < 0.5 * bumps["carried"]
    assert surface["interpolated"].mean() == pytest.approx(surface["carried"].mean(), abs=2)


def test_a_recording_without_soil_in_view_is_refused(cases, taichi):
    far = np.full((2, 3), 4.0)
    with pytest.raises(ValueError, match=r"no particle .* in the camera's view"):
        first_region(cases.recording(far, far), cases.scene())


def coarse(scene, cut):
    return scene.model_copy(update={"texture": scene.texture.model_copy(update={"smallest_drawn": cut})})


def test_grains_under_the_smallest_drawn_are_left_out_and_the_others_stay_as_many(rest, grains):
    scene = coarse(rest.scene, 0.75)
    cut = 0.75 * scene.camera.metres_per_pixel
    drawn = strew(scene, first_region(rest.recording, scene))
    assert drawn.diameter.min() >= cut > grains.diameter.min()
    kept = grains.diameter[grains.diameter >= cut]
    assert drawn.count == pytest.approx(kept.size, rel=0.05)
    assert np.sum(drawn.diameter**2) == pytest.approx(np.sum(kept**2), rel=0.05)


def test_finer_grains_are_a_tone_between_void_and_soil(rest):
    scene = rest.scene
    assert tone_behind(scene) == scene.light.void
    tones = [tone_behind(coarse(scene, cut)) for cut in (0.5, 0.75, 1.5)]
    assert scene.light.void < tones[0] < tones[1] < tones[2] < 1


def test_a_cut_above_every_grain_is_refused(rest):
    sizes = rest.scene.soil.grain_sizes.model_copy(update={"median": 0.06e-3, "largest": 0.1e-3})
    scene = rest.scene.model_copy(update={"soil": rest.scene.soil.model_copy(update={"grain_sizes": sizes})})
    with pytest.raises(ValueError, match=r"texture\.smallest_drawn = 2\.0 px: .* is allowed"):
        drawn_sizes(coarse(scene, 2.0))


def test_patches_have_as_much_variance_in_every_octave_and_the_deviation_asked_for():
    longest = 64.0
    fields = np.array([patch_field((128, 128), longest, np.random.default_rng(seed)) for seed in range(40)])
    assert np.mean(fields**2) == pytest.approx(1, rel=0.15)
    power = np.mean(np.abs(np.fft.fft2(fields * np.outer(np.hanning(128), np.hanning(128)))) ** 2, axis=0)
    wave = np.hypot(np.fft.fftfreq(128)[:, None], np.fft.fftfreq(128)[None, :])
    octaves = [power[(wave >= low) & (wave < 2 * low)].sum() for low in (0.06, 0.12, 0.24)]
    assert octaves == pytest.approx([np.mean(octaves)] * 3, rel=0.15)


def test_patches_are_part_of_the_grains_albedo(rest, cases):
    plain = strew(rest.scene, first_region(rest.recording, rest.scene))
    scene = cases.scene(texture={"patches": 0.0})
    even = strew(scene, first_region(rest.recording, scene))
    ratio = plain.brightness / even.brightness
    assert np.array_equal(plain.x, even.x)
    assert 0.2 * rest.scene.texture.patches < ratio.std() < 2 * rest.scene.texture.patches
    # Neighbours lie in one patch.
    near = np.hypot(np.diff(plain.x), np.diff(plain.z)) < cases.pixel
    assert np.abs(np.diff(ratio)[near]).mean() < 0.3 * ratio.std()
