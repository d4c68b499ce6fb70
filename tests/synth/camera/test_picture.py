import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from synth.camera.cover import Cover, cover
from synth.camera.motion import Placement
from synth.camera.picture import light_on_sensor
from synth.camera.samples import in_groups
from synth.camera.sensor import expose
from synth.camera.texture import MicroGrains
from synth.camera.tiles import TILE, sort_into_tiles
from synth.camera.view import View
from synth.truth import grains_and_motion, true_motion

WHEEL = 8e-3  # m
FINE = 12
"""Samples along each side of a pixel, where it is looked at what is left of errors."""


def wheel_scene(cases, scene):
    implement = scene.implement.model_copy(update={"radius": WHEEL})
    return scene.model_copy(update={"implement": implement})


def mismatch(first, second, u, v, inside):
    """Deviation of the second picture, sampled where the first one goes to, / contrast of the first."""
    height, width = first.shape
    y, x = np.mgrid[:height, :width].astype(float)
    arrived = map_coordinates(second.astype(float), [y + v, x + u], order=5)
    return np.sqrt(np.mean((arrived - first)[inside] ** 2)) / first[inside].std()


@pytest.mark.parametrize("name", ["rotation", "shear"])
def test_the_second_picture_sampled_at_the_truth_is_the_first(cases, fields, photograph, name):
    case = cases.case(fields[name](0.02), lens={"blur": 1.0}, camera={"supersampling": FINE})
    truth = true_motion(case.recording, case.scene, 0, 1)
    first, second = photograph(case, 0), photograph(case, 1)
    u, v = truth.u.values, truth.v.values
    inside = np.zeros(u.shape, bool)
    inside[6:-6, 6:-6] = True
    inside &= ~truth.mixed.values
    right = mismatch(first, second, u, v, inside)
    assert right < 0.04  # what the samples within a pixel alias, and the light that stays as grains turn
    for wrong in [(u + 0.5, v), (u, v + 0.5), (-u, v), (u, -v), (v, u), (-u, -v)]:
        if name == "shear" and np.array_equal(np.abs(wrong[1]), np.abs(v)) and wrong[0] is u:
            continue  # simple shear has next to no v whose sign could be wrong
        assert mismatch(first, second, *wrong, inside) > 3 * right


def test_a_grain_is_drawn_in_its_place(cases, taichi):
    x, y, radius = 30.3, 20.8, 4.0
    light = light_on_sensor(*one_grain(cases, x, y, radius))
    light = light - light[0, 0]
    rows, columns = np.mgrid[: light.shape[0], : light.shape[1]]
    assert np.average(columns, weights=light) == pytest.approx(x, abs=0.02)
    assert np.average(rows, weights=light) == pytest.approx(y, abs=0.02)
    assert (light > light.max() / 2).sum() == pytest.approx(np.pi * radius**2, rel=0.05)


def one_grain(cases, x, y, radius):
    """Scene, micro-grains, placement and cover of a single flat grain in a wide void."""
    from synth.camera import cover_kernels

    scene = cases.scene(texture={"roundness": 0.0, "facet_slope": 0.0}, camera={"supersampling": FINE})
    height, width, margin, sampling = 40, 64, 4, FINE
    view = View(width, height, cases.pixel, 0.0, 0.0)
    world_x, world_z = view.to_world(np.array([x]), np.array([y]))
    zero, depth = np.zeros(1), np.zeros(1, np.int32)
    flat = zero.astype(np.float32)
    grains = MicroGrains(world_x, world_z, zero + 2 * radius * cases.pixel, flat + 0.5, flat, flat, depth)
    placement = Placement(0, world_x, world_z, zero, np.ones(1, np.uint8))
    tiled = sort_into_tiles(grains, placement, view, sampling, margin)
    shape = height + 2 * margin, width + 2 * margin
    samples, centres = np.empty((*shape, sampling, sampling), np.int32), np.empty(shape, np.int32)
    sorted_grains = (tiled.first, tiled.columns, tiled.place, tiled.key, TILE)
    cover_kernels.cover_by_grains(sampling)(*sorted_grains, in_groups(samples), centres)
    centres = centres[margin:-margin, margin:-margin].copy()
    rows, columns = np.mgrid[:height, :width]
    assert np.array_equal(centres != cover_kernels.NOTHING, np.hypot(columns - x, rows - y) <= radius)
    soil = np.ones((height, width), bool)
    return scene, grains, placement, Cover(view, tiled, None, samples, centres, soil, sampling, margin)


def test_a_shift_by_whole_pixels_shifts_the_picture(cases, fields, photograph):
    case = cases.case(fields["translation"](3, 2), frames=2)
    first, second = photograph(case, 0), photograph(case, 1)
    assert np.abs(second[4:-8, 9:-4] - first[6:-6, 6:-7]).max() < 1e-5


def test_a_travelling_camera_over_static_soil_shifts_the_picture_back(cases, fields, photograph):
    carriage = [0.0, 3 * cases.pixel]
    case = cases.case(fields["rest"], carriage=carriage, camera={"follows": "carriage"})
    first, second = photograph(case, 0), photograph(case, 1)
    assert np.abs(second[:, :-3] - first[:, 3:]).max() < 1e-5


def test_the_wheel_is_drawn_in_its_place_and_turns(cases, fields, photograph):
    axle = [cases.centre[0] + 1.5 * cases.pixel, cases.centre[0] + 4.5 * cases.pixel], cases.centre[1]
    case = cases.case(fields["rest"], implement=axle, turn=[0.0, -0.1], lens={"blur": 0.0})
    case = type(case)(wheel_scene(cases, case.scene), case.recording)
    first = photograph(case, 0)
    # Dark where the wheel is: its area and centroid tell place and size to a fraction of a pixel.
    y, x = np.mgrid[:96, :128].astype(float)
    axle_x, axle_y, radius = 63.5 + 1.5, 47.5, WHEEL / cases.pixel
    away = np.hypot(x - axle_x, y - axle_y)
    rows, columns = wheel_samples(case)
    assert (columns.mean(), rows.mean()) == pytest.approx((axle_x, axle_y), abs=0.01)
    assert first[away < radius - 1].max() < 0.16
    assert first[(away > radius + 1) & (away < radius + 6)].mean() > 0.35
    assert np.median(first[(away > radius - 2) & (away < radius - 0.8)]) < 0.12
    truth = true_motion(case.recording, case.scene, 0, 1)
    inside = away < radius - 6
    second = photograph(case, 1)
    u, v = truth.u.values, truth.v.values
    right = mismatch(first, second, np.nan_to_num(u), np.nan_to_num(v), inside)
    assert right < 0.2
    assert mismatch(first, second, 3.0 + 0 * u, 0 * v, inside) > 2.5 * right  # shifted, not turned


def wheel_samples(case):
    """Image coordinates of the samples that the wheel covers in the first frame: rows, columns."""
    grains, motion = grains_and_motion(case.recording, case.scene)
    covered = cover(case.scene, case.recording, grains, motion.start())
    j, i, b, a = np.nonzero(covered.samples == -1)
    return (pixel - covered.margin + (n + 0.5) / covered.sampling - 0.5 for pixel, n in ((j, b), (i, a)))


def test_the_sensor_adds_the_noise_it_says(cases):
    scene = cases.scene(sensor={"bits": 16, "full_well": 10_000.0, "read_noise": 20.0, "black_level": 0.02})
    levels = expose(scene, np.full((400, 400), 0.4, np.float32), 0) / 65535
    assert levels.mean() == pytest.approx(0.42, abs=1e-4)
    assert levels.std() == pytest.approx(np.sqrt(0.4 * 10_000 + 20.0**2) / 10_000, rel=0.02)


def test_noise_is_drawn_anew_in_every_frame_and_the_same_every_time(cases):
    scene, light = cases.scene(), np.full((50, 50), 0.4, np.float32)
    assert np.array_equal(expose(scene, light, 3), expose(scene, light, 3))
    assert not np.array_equal(expose(scene, light, 3), expose(scene, light, 4))


def test_grey_levels_are_clipped_and_of_the_sensors_depth(cases):
    dark = cases.scene(sensor={"bits": 8, "read_noise": 0.0, "black_level": 0.0})
    assert expose(dark, np.zeros((4, 4), np.float32), 0).max() == 0
    assert expose(dark, np.full((4, 4), 3.0, np.float32), 0).min() == 255
    assert expose(cases.scene(sensor={"bits": 16}), np.zeros((4, 4), np.float32), 0).dtype == np.uint16


def test_vignetting_darkens_the_corners_by_its_share(cases, fields, photograph):
    clear = photograph(cases.case(fields["rest"]), 0)
    dimmed = photograph(cases.case(fields["rest"], lens={"vignetting": 0.3}), 0)
    ratio = dimmed / clear
    assert ratio[0, 0] == pytest.approx(0.7, abs=1e-5)
    assert ratio[47:49, 63:65] == pytest.approx(1.0, abs=1e-3)


def test_rows_that_two_products_share_are_never_summed_twice(monkeypatch):
    """12 rows are two products of 8: side by side, one could add to what the other has found."""
    from synth.camera import picture

    weights = picture._lens_and_pixel(0.7, 4)
    fine = np.random.default_rng(0).random((4 * 11 + len(weights), 4000)).astype(np.float32)
    exact = np.stack([weights @ fine[4 * row : 4 * row + len(weights)] for row in range(12)])
    monkeypatch.setattr(picture, "thread_count", lambda: 2)
    for _ in range(150):
        filtered = np.empty((12, 4000), np.float32)
        picture._filter_rows(fine, weights, 4, filtered)
        np.testing.assert_allclose(filtered, exact, rtol=1e-5)
