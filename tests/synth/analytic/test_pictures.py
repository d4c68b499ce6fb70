"""Pictures and truth of analytic scenes belong together, to a small part of a pixel."""

import math

import numpy as np
import pytest
from scipy.integrate import dblquad
from scipy.ndimage import map_coordinates

from synth import Footage, load_scene, picture_pair, render, simulate, true_motion
from synth.analytic.picture import Grains, light_of
from synth.scene import AnalyticScene, SceneError, parse_scene
from synth.scene_files import scene_names
from synth.truth import VARIABLES

ANALYTIC = [name for name in scene_names() if isinstance(load_scene(name), AnalyticScene)]


def make(**tables):
    """A small quick sand without noise; `tables` change keys of its tables."""
    scene = load_scene("sand_rotation", quick=True).to_dict()
    scene["camera"].update(width=160, height=120, scored_radius=None)
    scene["sensor"].update(noise=0.0)
    for table, keys in tables.items():
        scene[table] = keys if "kind" in keys else {**scene[table], **keys}
    return parse_scene({name: _without_none(table) for name, table in scene.items()})


def _without_none(table):
    return {k: v for k, v in table.items() if v is not None} if isinstance(table, dict) else table


def sampled(picture, displacement):
    """`picture` where the first one's pixels have gone to, by quintic splines."""
    height, width = picture.shape
    y, x = np.mgrid[:height, :width].astype(float)
    return map_coordinates(picture, [y + displacement[..., 1], x + displacement[..., 0]], order=5)


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def test_the_issues_scenes_are_shipped():
    assert set(ANALYTIC) == {
        "sand_rotation",
        "sand_low_contrast",
        "sand_defocus",
        "sand_aliased",
        "shear_band",
        "sinusoidal_strain",
    }
    for name in ANALYTIC:
        camera = load_scene(name).camera
        assert (camera.height, camera.width) == (600, 1200)


def test_one_grain_is_integrated_over_every_pixel():
    scene = make(camera={"width": 32, "height": 32})
    x, y, deviation, light = 0.3, -2.2, 0.6, 500.0
    one = Grains(*(np.array([value]) for value in (x, y, deviation, light)))
    picture = light_of(scene, one, 0) - scene.grains.mean
    column, row = x + 15.5, y + 15.5
    for i, j in [(13, 16), (13, 15), (14, 16), (12, 18)]:
        density = lambda a, b: (  # noqa: E731
            math.exp(-((a - row) ** 2 + (b - column) ** 2) / (2 * deviation**2))
            / (2 * math.pi * deviation**2)
        )
        exact = light * dblquad(density, j - 0.5, j + 0.5, i - 0.5, i + 0.5, epsabs=1e-12)[0]
        assert picture[i, j] == pytest.approx(exact, rel=1e-7, abs=1e-6)
    assert picture.sum() == pytest.approx(light, rel=1e-6)
    rows, columns = np.mgrid[:32, :32]
    # Pixels as coarse as the grain move its centroid by up to exp(-2 pi^2 deviation^2) / pi.
    assert np.average(columns, weights=picture) == pytest.approx(column, abs=3e-4)
    assert np.average(rows, weights=picture) == pytest.approx(row, abs=3e-4)


def test_the_tiles_of_a_picture_leave_no_seam():
    scene = make(lens={"blur": 1.0})
    grid = np.mgrid[-60:61, -80:81].astype(float)
    count = grid[0].size
    grains = Grains(grid[1].ravel(), grid[0].ravel(), np.full(count, 1.3), np.ones(count))
    # A grain on every pixel corner: the same light everywhere.
    inner = light_of(scene, grains, 0)[10:-10, 10:-10]
    assert np.ptp(inner) < 2e-6


@pytest.mark.parametrize(("contrast", "grains"), [(32.0, {}), (15.0, {"smallest": 0.7, "largest": 1.2})])
def test_the_contrast_is_what_was_asked_for(contrast, grains):
    scene = make(grains={"contrast": contrast, **grains}, camera={"width": 400, "height": 300})
    picture = picture_pair(scene, clean=True).first
    assert picture.std() == pytest.approx(contrast, rel=0.03)
    assert picture.mean() == pytest.approx(120.0, abs=1.0)


BANDED = {"lens": {"blur": 2.0}, "grains": {"contrast": 30.0}}
"""A lens that passes 3e-9 of the finest wave that pixels can hold: splines are next to exact."""


@pytest.mark.parametrize("name", ["rotation", "translation"])
def test_the_second_picture_sampled_at_the_truth_is_the_first(name):
    motions = {
        "rotation": {"kind": "rotation", "angle": 0.03},
        "translation": {"kind": "translation", "u": 2.3, "v": -1.6},
    }
    pair = picture_pair(make(motion=motions[name], **BANDED), clean=True)
    inside = np.s_[12:-12, 12:-12]
    u, v = np.moveaxis(pair.displacement, -1, 0)
    right = rms((sampled(pair.second, pair.displacement) - pair.first)[inside]) / 30.0
    assert right < 4e-5  # what quintic splines leave of a translation without any error
    # A thousandth of a pixel is seen ...
    for wrong in [(u + 1e-3, v), (u, v + 1e-3)]:
        assert rms((sampled(pair.second, np.stack(wrong, -1)) - pair.first)[inside]) / 30.0 > 2e-4
    # ... and the usual mistakes are far away.
    for wrong in [(u + 0.5, v), (u, v + 0.5), (-u, v), (u, -v), (v, u), (-u, -v)]:
        assert rms((sampled(pair.second, np.stack(wrong, -1)) - pair.first)[inside]) / 30.0 > 0.1


@pytest.mark.parametrize("name", ["shear_band", "sinusoidal_strain"])
def test_where_soil_is_strained_pictures_differ_by_no_more_than_round_grains_do(name):
    scene = load_scene(name, quick=True)
    scene = scene.model_copy(update={"lens": scene.lens.model_copy(update={"blur": 1.6})})
    pair = picture_pair(scene, clean=True)
    off = np.abs(sampled(pair.second, pair.displacement) - pair.first) / pair.first.std()
    strain = true_motion(simulate(scene), scene, 0, 1).strain_rate.values
    inside = np.zeros(off.shape, bool)
    inside[12:-12, 12:-12] = True
    if name == "shear_band":  # in the sinusoids no place is far from strain
        assert rms(off[inside & (strain < 1e-4)]) < 1e-4
    for least in (0.02, 0.04, 0.08):
        # A strain of e over about a standard deviation of a grain is e of its contrast.
        assert rms(off[inside & (strain > least) & (strain < 2 * least)]) < 2 * least


@pytest.mark.parametrize("name", ANALYTIC)
def test_the_truth_is_the_formula_for_any_two_frames(name):
    scene = load_scene(name, quick=True)
    scene = scene.model_copy(update={"timing": scene.timing.model_copy(update={"frame_count": 4})})
    recording = simulate(scene)
    height, width = scene.camera.height, scene.camera.width
    y, x = np.mgrid[:height, :width].astype(float)
    for first, second in ((0, 1), (1, 3), (3, 1)):
        truth = true_motion(recording, scene, first, second)
        u, v = scene.motion.displacement(x - (width - 1) / 2, y - (height - 1) / 2, first, second)
        assert truth.u.dtype == truth.v.dtype == np.float32
        assert np.hypot(truth.u - u, truth.v - v).max() < 1e-5
        assert {variable: truth[variable].dtype.name for variable in VARIABLES} == {
            variable: dtype for variable, (dtype, _, _) in VARIABLES.items()
        }


def test_strain_and_rotation_follow_the_conventions_of_a_recording():
    shear = make(motion={"kind": "simple_shear", "shear": 0.04})
    truth = true_motion(simulate(shear), shear, 0, 1)
    assert truth.strain_rate.values == pytest.approx(0.04, rel=1e-5)
    assert truth.rotation.values == pytest.approx(-math.atan2(0.04, 2), rel=1e-5)  # from y to x
    turned = make(motion={"kind": "rotation", "angle": 0.03})
    truth = true_motion(simulate(turned), turned, 0, 1)
    assert truth.strain_rate.max() < 1e-6
    assert truth.rotation.values == pytest.approx(-0.03)  # counter-clockwise is negative from x to y down
    assert not truth.mixed.any()
    assert truth.soil.all()
    assert np.isinf(truth.distance_to_discontinuity).all() and np.isnan(truth.discontinuity_jump).all()


def test_discontinuities_are_those_of_a_recording():
    from synth.camera.discontinuities import discontinuities
    from synth.devices import start_taichi

    start_taichi()
    scene = load_scene("shear_band", quick=True)
    truth = true_motion(simulate(scene), scene, 0, 1)
    u, v = truth.u.values, truth.v.values
    expected = discontinuities(u, v, np.zeros(u.shape, bool))
    distance = truth.distance_to_discontinuity.values
    np.testing.assert_allclose(distance, expected["distance_to_discontinuity"], rtol=1e-6)
    # At places as far from two jumps either may be told.
    same = np.isclose(truth.discontinuity_jump, expected["discontinuity_jump"], atol=1e-4)
    assert same.mean() > 0.95
    assert truth.mixed.values[distance < 1].all()


def test_only_what_stays_in_the_picture_and_within_the_radius_is_scored():
    pair = picture_pair("sand_rotation", quick=True)
    y, x = np.mgrid[:240, :400].astype(float)
    away = np.hypot(x - 199.5, y - 119.5)
    assert not pair.valid[away > 190].any()
    assert pair.valid[away < 115].all()
    shifted = picture_pair(make(motion={"kind": "translation", "u": 2.5, "v": -1.25}))
    stays = np.zeros((120, 160), bool)
    stays[2:, :157] = True
    np.testing.assert_array_equal(shifted.valid, stays)


def test_a_seed_is_a_texture_and_noise_and_not_a_motion():
    one, again, other = (picture_pair("sand_rotation", quick=True, seed=seed) for seed in (1, 1, 2))
    assert np.array_equal(one.second, again.second)
    assert np.abs(np.corrcoef(one.first.ravel(), other.first.ravel())[0, 1]) < 0.03
    assert np.array_equal(one.displacement, other.displacement)


def test_noise_and_light_change_as_the_scene_says():
    still = {"motion": {"kind": "translation", "u": 0.0, "v": 0.0}}
    lit = make(sensor={"bits": 16, "gain": 0.9, "offset": 8.0}, grains={"contrast": 15.0}, **still)
    pair = picture_pair(lit)
    assert pair.first.dtype == np.uint16
    assert np.abs(0.9 * pair.first + 8 * 257.0 - pair.second).max() <= 1.0
    noisy = picture_pair(make(sensor={"noise": 8.0}, grains={"contrast": 15.0}, **still))
    apart = noisy.second.astype(float) - noisy.first
    assert apart.std() == pytest.approx(8 * math.sqrt(2), rel=0.02)
    assert apart.mean() == pytest.approx(0, abs=0.3)


def test_footage_holds_what_the_pair_in_memory_has(tmp_path):
    scene = load_scene("shear_band", quick=True, seed=3)
    pair = picture_pair(scene)
    with render(simulate(scene), scene, tmp_path / "footage") as footage:
        assert isinstance(footage, Footage)
        assert np.array_equal(footage.picture(0), pair.first)
        assert np.array_equal(footage.picture(1), pair.second)
        truth = footage.truth(0)
        assert np.array_equal(np.stack([truth.u, truth.v], -1), pair.displacement)
        assert np.array_equal(truth.valid, pair.valid)
        assert truth.attrs["scene"] == "shear_band"


def test_grains_come_in_from_outside_as_others_leave():
    scene = make(motion={"kind": "translation", "u": 9.0, "v": -7.0}, timing={"frame_count": 6})
    last = picture_pair(scene, first=4, second=5, clean=True).second
    assert np.abs(last[:, :8].std() / last.std() - 1) < 0.15
    assert np.abs(last[-8:].std() / last.std() - 1) < 0.15


def test_what_cannot_be_is_refused():
    with pytest.raises(
        ValueError, match="plate_rotation: kind = 'plate_rotation': an analytic scene is needed"
    ):
        picture_pair("plate_rotation")
    tables = load_scene("sinusoidal_strain").to_dict()
    tables["camera"].pop("scored_radius")
    tables["timing"]["frame_count"] = 9
    with pytest.raises(SceneError, match=r"timing\.frame_count = 9: .*fewer frames"):
        parse_scene(tables)
    tables["timing"]["frame_count"], tables["motion"]["kind"] = 2, "vortex"
    with pytest.raises(SceneError, match=r"motion\.kind = 'vortex': allowed are .*'shear_band'"):
        parse_scene(tables)
