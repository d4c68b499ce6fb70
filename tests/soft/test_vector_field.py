"""The form of PIV programs: x, y and time, y up, unmeasured NaN."""

import numpy as np
import pytest

from soft import ImageSequence, analyze, vector_field


@pytest.fixture(scope="module")
def turned(moved):
    """Turned counter-clockwise, as the picture shows it, by 0.02 rad a frame."""
    first, second, _ = moved(matrix=((1.0, 0.02), (-0.02, 1.0)), shape=(160, 200))
    sequence = ImageSequence.from_arrays([first, second], metres_per_pixel=1e-3, frame_rate=10)
    return analyze(sequence, method="robust-affine", soil="all")


def test_curl_has_the_usual_sign_and_size(turned):
    field = vector_field(turned, stride=8)
    inner = field.isel(t=0, x=slice(5, -5), y=slice(5, -5))
    curl = inner["v"].differentiate("x") - inner["u"].differentiate("y")
    assert float(curl.median()) == pytest.approx(2 * 0.02 * 10, rel=0.02)
    assert field["u"].attrs["units"] == "m/s" and field["x"].attrs["units"] == "m"


def test_vectors_are_samples_at_their_places(turned):
    field = vector_field(turned, stride=16)
    assert field["u"].dims == ("y", "x", "t")
    row, column = 24, 40
    x, y = column * 1e-3, (160 - 1 - row) * 1e-3
    vector = field.sel(x=x, y=y, method="nearest").isel(t=0)
    assert (float(vector["x"]), float(vector["y"])) == pytest.approx((x, y))
    assert float(vector["u"]) == turned["velocity_x"].values[0, row, column]
    assert float(vector["v"]) == turned["velocity_z"].values[0, row, column]


def test_what_was_not_measured_is_nan_and_said(turned):
    cut = turned.copy(deep=True)
    cut["soil"][:, :, :100] = False
    field = vector_field(cut, stride=4)
    np.testing.assert_array_equal(np.isnan(field["u"]), field["chc"] == 0)
    assert np.isnan(field["u"].sel(x=slice(None, 0.099))).all()


def test_without_scale_it_is_in_px(moved):
    first, second, _ = moved(shift=(0.0, -2.0))
    flow = analyze(ImageSequence.from_arrays([first, second]), method="dis", soil="all")
    field = vector_field(flow, stride=8)
    assert field["v"].attrs["units"] == "px/frame"
    assert float(field["v"].median()) == pytest.approx(2.0, abs=0.05)


def test_pivpy_takes_it(turned):
    pytest.importorskip("pivpy", reason="pivpy is not installed")
    field = vector_field(turned, stride=8).piv.vorticity()
    inner = field["w"].isel(t=0, x=slice(5, -5), y=slice(5, -5))
    assert float(inner.median()) == pytest.approx(2 * 0.02 * 10, rel=0.02)
