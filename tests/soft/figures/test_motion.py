import numpy as np
import pytest
from matplotlib.image import imread

from soft import (
    AveragingGain,
    ImageSequence,
    MeanFlow,
    ShearInterface,
    analyze,
    average_figure,
    bucket_figure,
    comparison_figure,
    direction_figure,
    motion_figure,
    picture_figure,
    speed_figure,
    write_figures,
)


@pytest.fixture(scope="module")
def measured(moved):
    """Soil at rest, and a block of it that goes up by 3 px."""
    first, second, _ = moved()
    _, block, _ = moved(shift=(0.0, -3.0))
    second[50:120, 70:150] = block[50:120, 70:150]
    sequence = ImageSequence.from_arrays([first, second], metres_per_pixel=2e-4, frame_rate=8)
    return analyze(sequence, soil="all"), sequence


def shown_on(axes):
    """What lies over the picture; NaN where the picture is seen."""
    return np.ma.filled(axes.get_images()[1].get_array().astype(float), np.nan)


def test_write_figures(measured, tmp_path):
    flow, sequence = measured
    paths = write_figures(flow, sequence, tmp_path / "deep" / "figures", pair=-1)
    assert [path.name for path in paths] == ["picture-0000.png", "speed-0000.png", "direction-0000.png"]
    for path in paths:
        assert imread(path)[..., :3].std() > 0.05, "the figure is empty"
    with pytest.raises(IndexError):
        write_figures(flow, sequence, tmp_path, pair=1)


def test_axes_and_scale_have_units(measured):
    flow, sequence = measured
    axes, bar = speed_figure(flow, sequence[0]).axes
    assert axes.get_xlabel() == "x [mm]"
    assert axes.get_ylim()[0] > axes.get_ylim()[1], "y must point down"
    assert bar.get_ylabel() == "speed [mm/s]"
    # 3 px at 0.2 mm and 8 frames a second.
    assert np.median(shown_on(axes)[60:110, 80:140]) == pytest.approx(4.8, rel=0.1)
    assert axes.get_images()[0].get_extent() == pytest.approx([-0.1, 43.9, 31.9, -0.1])


def test_without_calibration_everything_is_in_px(measured):
    flow, sequence = measured
    plain = flow.drop_vars(["velocity_x", "velocity_z"])
    for name in ("metres_per_pixel", "frame_rate"):
        del plain.attrs[name]
    axes, bar = speed_figure(plain, sequence[0]).axes
    assert (axes.get_xlabel(), bar.get_ylabel()) == ("x [px]", "speed [px/frame]")
    assert np.median(shown_on(axes)[60:110, 80:140]) == pytest.approx(3, rel=0.1)
    assert picture_figure(sequence[0]).axes[0].get_xlabel() == "x [px]"


def test_motion_over_several_frames_is_told_per_frame(measured):
    flow, sequence = measured
    wide = flow.assign_coords(second_frame=("pair", [3], flow["second_frame"].attrs))
    shown = shown_on(speed_figure(wide, sequence[0]).axes[0])
    assert np.median(shown[60:110, 80:140]) == pytest.approx(1.6, rel=0.1)


def test_direction_is_shown_where_soil_moves_and_up_is_up(measured):
    flow, sequence = measured
    axes = direction_figure(flow, sequence[0]).axes[0]
    assert np.nanmedian(shown_on(axes)) == pytest.approx(np.pi / 2, abs=0.1)
    assert np.isnan(shown_on(axes)[:30]).all()


def test_arrows_are_samples_that_point_up_on_the_page(measured):
    flow, sequence = measured
    (arrows,) = direction_figure(flow, sequence[0], arrows=True).axes[0].collections[-1:]
    assert len(arrows.U) > 10
    np.testing.assert_allclose(arrows.V, 1, atol=0.05)
    assert arrows.angles == "uv", "by the page, not by the axes, whose y points down"
    x, y = arrows.XY.T / 0.2
    assert (x > 65).all() and (x < 155).all() and (y > 45).all() and (y < 125).all()


def test_the_wheel_has_the_colours_of_the_map(measured):
    flow, sequence = measured
    for colours in ("even", "paper"):
        axes, wheel = direction_figure(flow, sequence[0], colours=colours).axes
        ring, image = wheel.collections[0], axes.get_images()[1]
        assert ring.get_cmap() == image.get_cmap()
        assert (ring.norm.vmin, ring.norm.vmax) == (image.norm.vmin, image.norm.vmax) == (-np.pi, np.pi)
        angles = ring.get_coordinates()[0, :, 0]
        np.testing.assert_allclose(ring.get_array()[0], (angles[:-1] + angles[1:]) / 2)


def test_a_measured_interface_takes_the_place_of_the_outline(measured):
    flow, sequence = measured
    line = np.array([[10.0, 20.0], [30.0, 40.0], [50.0, 20.0]])
    axes = speed_figure(flow, sequence[0], interface=ShearInterface((line,), "")).axes[0]
    (drawn,) = axes.collections
    np.testing.assert_allclose(drawn.get_segments()[0], line * 0.2)


def test_no_interface_is_drawn_where_soil_ends(measured):
    flow, sequence = measured
    cut = flow.copy(deep=True)
    cut["soil"][:, :, 110:] = False
    cut["moving"][:] = cut["moving"] & cut["soil"]
    (outline,) = speed_figure(cut, sequence[0]).axes[0].collections
    x = np.concatenate([path.vertices[:, 0] for path in outline.get_paths()]) / 0.2
    assert x.max() <= 110 and (x < 80).any()


def test_single_pair_and_average_have_one_scale(measured):
    flow, sequence = measured
    half = flow.isel(pair=0)
    u, v = half["inertial_u"].values / 2, half["inertial_v"].values / 2
    nothing = np.zeros(0)
    gain = AveragingGain(nothing, nothing, nothing, nothing)
    everywhere = np.ones(u.shape, bool)
    mean = MeanFlow(u, v, 7 * everywhere, 0 * u, 0 * u, everywhere, tuple(range(7)), gain)
    single, averaged, *_ = average_figure(flow, mean, sequence[0]).axes
    assert single.get_images()[1].get_clim() == averaged.get_images()[1].get_clim()
    assert np.nanmax(shown_on(averaged)) == pytest.approx(np.nanmax(shown_on(single)) / 2, rel=1e-6)
    assert "7 pairs" in averaged.get_title(loc="left")


def test_runs_beside_each_other_have_scales_of_their_own(measured):
    flow, sequence = measured
    slow = flow.copy(deep=True)
    for name in ("inertial_u", "inertial_v"):
        slow[name][:] = slow[name] / 10
    figure = comparison_figure([("Rolling", flow, sequence[0]), ("Pushed", slow, sequence[0])])
    titles = {axes.get_title(loc="left"): axes for axes in figure.axes if axes.get_title(loc="left")}
    assert {*titles} == {"Rolling: speed", "Rolling: direction", "Pushed: speed", "Pushed: direction"}
    tops = [titles[f"{name}: speed"].get_images()[1].get_clim()[1] for name in ("Rolling", "Pushed")]
    assert tops[0] == pytest.approx(10 * tops[1], rel=1e-5)
    np.testing.assert_allclose(
        shown_on(titles["Rolling: direction"]), shown_on(titles["Pushed: direction"]), atol=1e-6
    )


def test_a_run_of_another_size_has_an_axis_of_its_own(measured):
    flow, sequence = measured
    cut, picture = flow.isel(y=slice(0, 100)), sequence[0][:100]
    for others, labelled in ((("Same", flow, sequence[0]), False), (("Cut", cut, picture), True)):
        figure = comparison_figure([("First", flow, sequence[0]), others])
        titles = {axes.get_title(loc="left"): axes for axes in figure.axes}
        for what in ("speed", "direction"):
            axes = titles[f"{others[0]}: {what}"]
            assert bool(axes.yaxis.get_tick_params()["labelleft"]) is labelled
            assert bool(axes.get_ylabel()) is labelled


@pytest.mark.parametrize("make", [motion_figure, bucket_figure])
def test_figures_of_two_panels_show_both(measured, make):
    flow, sequence = measured
    titles = " ".join(axes.get_title(loc="left") for axes in make(flow, sequence[0]).axes)
    assert "speed" in titles and "Direction" in titles


def test_nothing_moves_is_said(moved):
    first, second, _ = moved()
    flow = analyze(ImageSequence.from_arrays([first, second]), soil="all")
    for make in (speed_figure, direction_figure):
        texts = [text.get_text() for text in make(flow, first).axes[0].texts]
        assert texts == ["no moving region found"]


def test_large_pictures_are_reduced():
    picture = np.random.default_rng(0).uniform(0, 255, (1000, 4000)).astype(np.float32)
    assert max(picture_figure(picture).axes[0].get_images()[0].get_array().shape) <= 1400


def test_other_colours_are_refused(measured):
    flow, sequence = measured
    with pytest.raises(ValueError, match="colours: 'rainbow': allowed are even, paper"):
        speed_figure(flow, sequence[0], colours="rainbow")
