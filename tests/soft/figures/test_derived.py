"""Rates, lines and profiles are shown with the right sign, place and unit."""

import numpy as np
import pytest

from soft import (
    FigureError,
    ImageSequence,
    analyze,
    average_flow,
    deformation_figure,
    gain_figure,
    profile_figure,
    streamlines_figure,
)

SHAPE = (160, 220)


def measured(moved, shape=SHAPE, **how):
    first, second, _ = moved(shape=shape, **how)
    sequence = ImageSequence.from_arrays([first, second], metres_per_pixel=1e-3, frame_rate=10)
    flow = analyze(sequence, method="robust-affine", soil="all")
    # A turned or sheared field as a whole moves; the segmentation looks for a part that does.
    flow["moving"][:] = True
    return flow, first


def middle_of(figure):
    values = figure.axes[0].get_images()[1].get_array()
    return float(np.nanmedian(np.ma.filled(values.astype(float), np.nan)[50:110, 70:150]))


@pytest.mark.parametrize(
    ("quantity", "matrix", "rate", "unit"),
    [
        # x' = x - 0.02 y, y' = y + 0.02 x with y down: clockwise as the picture shows it.
        ("rotation", ((1.0, -0.02), (0.02, 1.0)), 0.2, "rotation rate [rad/s]"),
        ("rotation", ((1.0, 0.02), (-0.02, 1.0)), -0.2, "rotation rate [rad/s]"),
        ("dilation", ((1.01, 0.0), (0.0, 1.01)), 0.2, "dilation rate [1/s]"),
        ("shear", ((1.0, 0.03), (0.0, 1.0)), 0.3, "shear rate [1/s]"),
    ],
)
def test_rates_of_known_motion(moved, quantity, matrix, rate, unit):
    flow, picture = measured(moved, matrix=matrix)
    figure = deformation_figure(flow, picture, quantity=quantity)
    assert middle_of(figure) == pytest.approx(rate, rel=0.05)
    assert figure.axes[1].get_ylabel() == unit
    low, high = figure.axes[0].get_images()[1].get_clim()
    assert low == (0 if quantity == "shear" else -high)


def test_without_scale_rates_are_a_frame(moved):
    flow, picture = measured(moved, matrix=((1.01, 0.0), (0.0, 1.01)))
    plain = flow.drop_vars(["velocity_x", "velocity_z"])
    for name in ("metres_per_pixel", "frame_rate"):
        del plain.attrs[name]
    figure = deformation_figure(plain, picture, quantity="dilation")
    assert middle_of(figure) == pytest.approx(0.02, rel=0.05)
    assert figure.axes[1].get_ylabel() == "dilation rate [1/frame]"


def test_other_quantities_are_refused(moved):
    flow, picture = measured(moved)
    with pytest.raises(FigureError, match="quantity: 'heat': allowed are shear, rotation, dilation"):
        deformation_figure(flow, picture, quantity="heat")


def test_streamlines_run_along_the_motion(moved):
    flow, picture = measured(moved, matrix=((1.0, -0.03), (0.03, 1.0)))
    axes = streamlines_figure(flow, picture, spacing=15).axes[0]
    lines = max(axes.collections, key=lambda drawn: len(drawn.get_paths())).get_segments()
    assert len(lines) > 3
    centre = np.array([(SHAPE[1] - 1) / 2, (SHAPE[0] - 1) / 2])
    for line in lines:  # mm, of 1 px each: circles around the centre
        radius = np.hypot(*(line - centre).T)
        assert np.ptp(radius) < 0.15 * radius.mean() + 1.5


def test_profile_is_that_of_the_strip(moved):
    flow, picture = measured(moved, matrix=((1.0, 0.02), (0.0, 1.0)))
    figure = profile_figure(flow, picture, x=110)
    (axes,) = (axes for axes in figure.axes if axes.get_xlabel() == "velocity [mm/s]")
    right = next(line for line in axes.lines if line.get_label() == "to the right")
    down = next(line for line in axes.lines if line.get_label() == "down")
    speed, depth = right.get_data()
    camera = float(flow["camera_u"][0]) * 10
    # u = 0.02 (y - centre) px a frame, ten frames a second, 1 mm a px.
    np.testing.assert_allclose(speed[20:140], 0.2 * (depth[20:140] - 79.5) - camera, atol=0.5)
    np.testing.assert_allclose(down.get_xdata()[20:140], 0, atol=0.5)
    assert axes.get_ylim()[0] > axes.get_ylim()[1], "depth points down"
    with pytest.raises(FigureError, match="must lie in the picture"):
        profile_figure(flow, picture, x=999)


def test_profile_looks_below_the_lowest_surface(moved):
    flow, picture = measured(moved, matrix=((1.0, 0.02), (0.0, 1.0)))
    cut = flow.copy(deep=True)
    cut["soil"][:, :30] = False
    cut["soil"][:, :60, 150:171] = False
    figure = profile_figure(cut, picture)
    strip = [line.get_xdata()[0] for line in figure.axes[0].lines]
    assert strip == pytest.approx([160 - 5.5, 160 + 5.5])


def test_gain_stands_beside_the_ideal(moved):
    pictures = [moved(shift=(0.0, -1.5 * k))[1] for k in range(6)]
    noise = np.random.default_rng(2)
    noisy = [np.clip(one + noise.normal(0, 8, one.shape), 0, 255).astype(np.float32) for one in pictures]
    mean = average_flow(analyze(ImageSequence.from_arrays(noisy), method="dis", soil="all"))
    ideal, measured = gain_figure(mean).axes[0].lines
    np.testing.assert_array_equal(ideal.get_xdata(), [1, 2])
    np.testing.assert_allclose(ideal.get_ydata(), [1, np.sqrt(2)])
    np.testing.assert_allclose(measured.get_ydata(), mean.gain.gain)
    single = average_flow(analyze(ImageSequence.from_arrays(pictures[:2]), method="dis", soil="all"))
    with pytest.raises(FigureError, match="average over 1 pair: at least 2 are needed"):
        gain_figure(single)
