import numpy as np
import pytest
from matplotlib.image import imread

from soft import ImageSequence, analyze, direction_figure, picture_figure, speed_figure, write_figures


@pytest.fixture(scope="module")
def measured(moved):
    """Soil at rest, and a block of it that goes up by 3 px."""
    first, second, _ = moved()
    _, block, _ = moved(shift=(0.0, -3.0))
    second[50:120, 70:150] = block[50:120, 70:150]
    sequence = ImageSequence.from_arrays([first, second], metres_per_pixel=2e-4, frame_rate=8)
    return analyze(sequence, soil="all"), sequence


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
    shown = np.ma.filled(axes.get_images()[1].get_array().astype(float), np.nan)
    # 3 px at 0.2 mm and 8 frames a second.
    assert np.median(shown[60:110, 80:140]) == pytest.approx(4.8, rel=0.1)
    plain = flow.drop_vars(["velocity_x", "velocity_z"])
    assert speed_figure(plain, sequence[0]).axes[1].get_ylabel() == "speed [px per frame]"
    assert picture_figure(sequence[0]).axes[0].get_xlabel() == "x [px]"


def test_direction_is_shown_where_soil_moves_and_up_is_up(measured):
    flow, sequence = measured
    axes = direction_figure(flow, sequence[0]).axes[0]
    shown = np.ma.filled(axes.get_images()[1].get_array().astype(float), np.nan)
    assert np.nanmedian(shown) == pytest.approx(np.pi / 2, abs=0.1)
    assert np.isnan(shown[:30]).all()


def test_nothing_moves_is_said(moved):
    first, second, _ = moved()
    flow = analyze(ImageSequence.from_arrays([first, second]), soil="all")
    for make in (speed_figure, direction_figure):
        texts = [text.get_text() for text in make(flow, first).axes[0].texts]
        assert texts == ["no moving region found"]


def test_large_pictures_are_reduced(moved):
    picture = np.random.default_rng(0).uniform(0, 255, (1000, 4000)).astype(np.float32)
    assert max(picture_figure(picture).axes[0].get_images()[0].get_array().shape) <= 1400
