"""Every nuisance does what it says, in the frame it belongs to; the truth knows those that move pictures."""

import numpy as np
import pytest

from synth.camera.nuisance import as_seen, flicker, vibration
from synth.recording import Recording
from synth.truth import true_motion

STEP = 6  # px a frame, of the travelling camera


def travelling(cases, fields, **tables):
    """Soil at rest before a camera that travels."""
    carriage = STEP * cases.pixel * np.arange(2)
    tables["camera"] = {"follows": "carriage", **tables.get("camera", {})}
    return cases.case(fields["rest"], carriage=carriage, **tables)


def effect(photograph, cases, fields, name, severity):
    """What a nuisance changes in the light of both pictures of a travelling camera."""
    clean = travelling(cases, fields)
    dirty = travelling(cases, fields, nuisance={name: severity})
    return [photograph(dirty, frame) - photograph(clean, frame) for frame in (0, 1)]


@pytest.mark.parametrize("name", ["scratches", "smudges"])
def test_marks_on_the_glass_move_with_static_soil(photograph, cases, fields, name):
    first, second = effect(photograph, cases, fields, name, 0.5)
    assert np.abs(first).max() > 0.05
    assert np.abs(second[:, :-STEP] - first[:, STEP:]).max() < 1e-5
    assert np.abs(second - first).max() > 0.02


def test_smudges_take_contrast_and_scratches_add_light(photograph, cases, fields):
    clean = photograph(travelling(cases, fields), 0)
    smudged = photograph(travelling(cases, fields, nuisance={"smudges": 1.0}), 0)
    touched = np.abs(smudged - clean) > 0.02
    # Of neighbours: a smudge's own light varies over the picture.
    contrast = [np.diff(light, axis=1)[touched[:, 1:]].std() for light in (clean, smudged)]
    assert contrast[1] < 0.8 * contrast[0]
    scratched = effect(photograph, cases, fields, "scratches", 0.5)[0]
    assert scratched.min() > -1e-5
    assert scratched.max() < 0.5


@pytest.mark.parametrize(("name", "severity"), [("dirt", 0.5), ("reflections", 0.3)])
def test_dirt_and_reflections_stay_in_the_picture(photograph, cases, fields, name, severity):
    clean = [photograph(travelling(cases, fields), frame) for frame in (0, 1)]
    dirty = [photograph(travelling(cases, fields, nuisance={name: severity}), frame) for frame in (0, 1)]
    if name == "dirt":
        first, second = (after / before for before, after in zip(clean, dirty, strict=True))
        assert first.min() < 1 - 0.4 * severity
        assert first.max() <= 1 + 1e-6
    else:
        first, second = (after - before for before, after in zip(clean, dirty, strict=True))
        assert first.max() == pytest.approx(severity, rel=0.05)
    assert np.abs(first - second).max() < 1e-4


def test_an_exposure_blurs_along_the_motion_about_the_same_place(photograph, cases, fields):
    field = fields["translation"](4, 0)
    sharp = photograph(cases.case(field, frames=3), 1)
    blurred = photograph(cases.case(field, frames=3, nuisance={"exposure": 1.0}), 1)
    inside = np.s_[8:-8, 12:-12]
    # The slope of a mean over 4 px is the difference of two values 4 px apart, a quarter of it.
    apart = (sharp[:, 4:] - sharp[:, :-4])[inside].std() / 4
    assert np.diff(blurred, axis=1)[inside].std() == pytest.approx(apart, rel=0.1)
    assert np.diff(blurred, axis=0)[inside].std() > 1.3 * apart
    # The mean of the sharp picture shifted by -1.75 to 1.75 px, which is what an open shutter sees.
    from scipy.ndimage import shift

    shifts = 4 * ((np.arange(8) + 0.5) / 8 - 0.5)
    expected = np.mean([shift(sharp, (0, s), order=5) for s in shifts], axis=0)
    assert np.std((blurred - expected)[inside]) < 0.15 * blurred[inside].std()


def test_distortion_is_in_the_truth_to_a_thousandth_of_a_pixel(cases, fields, offsets):
    case = cases.case(fields["translation"](3, 2), nuisance={"distortion": 0.1})
    truth = true_motion(case.recording, case.scene, 0, 1)
    height, width = cases.size
    x, y = offsets  # of distorted pixels from the axis
    bend = 0.1 / ((height**2 + width**2) / 4)
    ideal = np.hypot(x, y)
    for _ in range(60):
        ideal = np.hypot(x, y) / (1 + bend * ideal**2)
    scale = 1 / (1 + bend * ideal**2)
    to_x, to_y = x * scale + 3, y * scale - 2
    factor = 1 + bend * (to_x**2 + to_y**2)
    # A grain moves as its centre does, and a pixel has its grain's motion: off by the change of the
    # distortion's gradient over a grain's radius.
    u, v = truth.u.values - (factor * to_x - x), truth.v.values - (factor * to_y - y)
    slope = 3 * 2 * bend * np.hypot(3, 2) * np.hypot(*offsets)
    assert np.all(np.hypot(u, v) <= slope * 5 + 1e-3)
    assert np.median(np.hypot(u, v)) < 0.01
    assert np.ptp(truth.u.values) > 0.3  # and not the same everywhere, as without distortion


def test_the_distorted_picture_moves_by_the_distorted_truth(cases, fields, photograph):
    from scipy.ndimage import map_coordinates

    tables = {"lens": {"blur": 1.0}, "camera": {"supersampling": 12}, "nuisance": {"distortion": 0.1}}
    case = cases.case(fields["rotation"](0.03), **tables)
    truth = true_motion(case.recording, case.scene, 0, 1)
    first, second = photograph(case, 0), photograph(case, 1)
    y, x = np.mgrid[: first.shape[0], : first.shape[1]].astype(float)
    inside = np.s_[10:-10, 10:-10]
    arrived = map_coordinates(second.astype(float), [y + truth.v.values, x + truth.u.values], order=5)
    assert np.std((arrived - first)[inside]) < 0.1 * first[inside].std()


def test_jitter_takes_the_picture_at_another_instant_and_the_truth_knows(cases, fields):
    case = cases.case(fields["translation"](4, 0), frames=5, nuisance={"jitter": 0.1})
    seen = as_seen(case.recording, case.scene)
    at = (seen.data["position_x"].values[:, 0] - case.recording.data["position_x"].values[0, 0]) / cases.pixel
    late = at / 4 - np.arange(5)
    assert np.abs(late[1:-1]).max() > 0.01
    truth = true_motion(case.recording, case.scene, 1, 2)
    assert truth.u.values == pytest.approx(at[2] - at[1], abs=1e-3)
    assert abs(at[2] - at[1] - 4) > 0.05


def test_an_elastic_rim_is_where_it_was_at_that_instant(cases, fields):
    case = cases.case(fields["translation"](4, 0), frames=5, nuisance={"jitter": 0.1})
    nodes = np.arange(5)[:, None] * [1.0, 2.0, 3.0]
    rim = dict.fromkeys(("rim_x", "rim_z"), (("frame", "node"), nodes))
    seen = as_seen(Recording(case.recording.data.assign(rim)), case.scene).data
    at = np.interp(seen["time"].values, case.recording.data["time"].values, np.arange(5))
    assert np.abs(at - np.arange(5)).max() > 0.01
    for name in rim:
        assert seen[name].values == pytest.approx(at[:, None] * [1.0, 2.0, 3.0])


def test_vibration_shakes_a_travelling_camera_only_and_the_truth_knows(cases, fields):
    still = {"vibration": 1.5}
    fixed = cases.case(fields["rest"], nuisance=still)
    assert np.abs(true_motion(fixed.recording, fixed.scene, 0, 1).u).max() < 1e-4
    case = travelling(cases, fields, nuisance=still)
    shakes = np.array([vibration(case.scene, frame) for frame in (0, 1)]) / cases.pixel
    truth = true_motion(case.recording, case.scene, 0, 1)
    assert truth.u.values == pytest.approx(-STEP - (shakes[1, 0] - shakes[0, 0]), abs=1e-3)
    assert truth.v.values == pytest.approx(shakes[1, 1] - shakes[0, 1], abs=1e-3)
    assert (truth.camera_u, truth.camera_v) == pytest.approx(
        (-STEP - (shakes[1, 0] - shakes[0, 0]), shakes[1, 1] - shakes[0, 1])
    )
    drawn = np.array([vibration(case.scene, frame) for frame in range(2000)]) / cases.pixel
    assert drawn.std(axis=0) == pytest.approx([1.5, 1.5], rel=0.1)


def test_flicker_scales_the_light_of_a_whole_picture(cases, fields, photograph):
    case = cases.case(fields["rest"], nuisance={"flicker": 0.2})
    clean = photograph(cases.case(fields["rest"]), 1)
    assert photograph(case, 1) == pytest.approx(clean * flicker(case.scene, 1), rel=1e-5)
    drawn = [flicker(case.scene, frame) for frame in range(2000)]
    assert (np.mean(drawn), np.std(drawn)) == pytest.approx((1.0, 0.2), rel=0.06)


def test_exchanged_grains_are_lost_to_the_truth_at_their_rate(cases, fields, photograph):
    case = cases.case(fields["rest"], frames=4, nuisance={"exchange": 0.1})
    one = true_motion(case.recording, case.scene, 1, 2)
    three = true_motion(case.recording, case.scene, 0, 3)
    assert one.valid.values.mean() == pytest.approx(0.9, abs=0.03)
    assert three.valid.values.mean() == pytest.approx(0.9**3, abs=0.05)
    assert np.isnan(one.u.values[~one.valid.values]).all()
    # What stays looks the same; what goes, does not.
    first, second = photograph(case, 1), photograph(case, 2)
    changed = np.abs(second - first)
    assert np.median(changed[one.valid.values]) < 0.3 * np.median(changed[~one.valid.values])
    assert np.mean(changed > 1e-3) > 0.1


def test_a_clean_scene_has_no_nuisance(cases, fields, photograph):
    nuisance = cases.scene().nuisance
    assert set(nuisance.model_dump().values()) == {0.0}
    case = cases.case(fields["rest"], frames=3)
    assert as_seen(case.recording, case.scene) is case.recording
    assert np.array_equal(photograph(case, 0), photograph(case, 2))


def test_dark_soil_before_a_light_implement_and_background(cases, fields, photograph):
    x, z = cases.lattice()
    below = z < cases.centre[1]
    recording = cases.recording([x[below]] * 2, [z[below]] * 2)
    scene = cases.scene(light={"background": 0.9, "implement": 0.8})
    dark = scene.soil.model_copy(update={"look": scene.soil.look.model_copy(update={"albedo": 0.15})})
    case = type(cases.case(fields["rest"]))(scene.model_copy(update={"soil": dark}), recording)
    picture = photograph(case, 0)
    assert picture[:30].mean() == pytest.approx(0.9, abs=0.01)
    assert picture[70:].mean() < 0.25
