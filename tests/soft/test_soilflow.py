"""One validator says what is wrong with a SoilFlow: its form, and its values when asked."""

import numpy as np
import pytest

from soft import ImageSequence, SoilFlowError, analyze, check_soil_flow, read_soil_flow


@pytest.fixture(scope="module")
def flow(moved):
    first, second, _ = moved(shift=(1.5, -0.75), shape=(90, 120))
    sequence = ImageSequence.from_arrays([first, second], metres_per_pixel=2e-4, frame_rate=8)
    measured = analyze(sequence, method="dis", soil="all")
    assert measured["valid"].any() and not measured["valid"].all(), "there must be both to check"
    return measured


def place(flow, name, wanted=True):
    """A pixel where a mask is as wanted."""
    return tuple(np.argwhere(flow[name].to_numpy() == wanted)[0])


def changed(flow, name, value, at):
    other = flow.copy(deep=True)
    other[name].to_numpy()[at] = value
    return other


def test_what_an_analysis_yields_passes(flow, tmp_path):
    assert check_soil_flow(flow, values=True) is flow
    flow.to_netcdf(tmp_path / "flow.nc", engine="h5netcdf")
    with read_soil_flow(tmp_path / "flow.nc") as stored:
        check_soil_flow(stored, values=True)


@pytest.mark.parametrize(
    ("name", "value", "where", "complaint"),
    [
        ("u", np.nan, True, "pair 0: valid, but u is not a number: 1 px, the first at x"),
        ("v", 1.0, False, "pair 0: v is told where not valid: 1 px"),
        ("inertial_u", 3.25, True, "pair 0: inertial_u is not u - camera_u: 1 px"),
        ("inertial_v", 3.25, True, "pair 0: inertial_v is not v - camera_v"),
        ("velocity_x", 1.0, True, "pair 0: velocity_x is not inertial_u in m/s"),
        ("velocity_z", 1.0, True, "pair 0: velocity_z is not inertial_v in m/s"),
        ("uncertainty_u", -0.1, True, "pair 0: uncertainty_u is below 0"),
        ("uncertainty_v", 0.1, False, "pair 0: uncertainty_v is told where not valid"),
    ],
)
def test_a_wrong_pixel_is_found(flow, name, value, where, complaint):
    wrong = changed(flow, name, value, place(flow, "valid", where))
    check_soil_flow(wrong)
    with pytest.raises(SoilFlowError, match=complaint):
        check_soil_flow(wrong, values=True)


def test_a_velocity_that_points_down_is_found(flow):
    wrong = flow.assign(
        velocity_z=(flow["velocity_z"].dims, -flow["velocity_z"].to_numpy(), flow["velocity_z"].attrs)
    )
    with pytest.raises(SoilFlowError, match="velocity_z is not inertial_v in m/s"):
        check_soil_flow(wrong, values=True)


def test_moving_must_be_soil(flow):
    wrong = changed(changed(flow, "soil", False, (0, 5, 7)), "moving", True, (0, 5, 7))
    with pytest.raises(SoilFlowError, match="moving, but not soil: 1 px, the first at x 7, y 5"):
        check_soil_flow(wrong, values=True)


def test_frames_go_forward(flow):
    wrong = changed(flow, "second_frame", 0, 0)
    with pytest.raises(SoilFlowError, match="pair 0: second_frame 0: must be after first_frame 0"):
        check_soil_flow(wrong, values=True)


def test_velocities_need_a_scale(flow):
    wrong = flow.copy()
    del wrong.attrs["metres_per_pixel"]
    with pytest.raises(SoilFlowError, match="metres_per_pixel is missing, but there are velocities"):
        check_soil_flow(wrong, values=True)


@pytest.mark.parametrize("size", [600, 1200])
def test_a_full_disk_ends_an_analysis_with_an_error_and_leaves_nothing_half_kept(moved, small_disk, size):
    disk, enlarge = small_disk(size)
    first, second, _ = moved(shift=(1.5, -0.75), shape=(200, 300))
    sequence = ImageSequence.from_arrays([first, second, first], metres_per_pixel=2e-4, frame_rate=8)

    def again():
        return analyze(sequence, method="dis", soil="all", path=disk / "dis.nc", keep=disk / "kept")

    with pytest.raises(OSError, match="No space left on device") as raised:
        again()
    assert str(disk) in str(raised.value.filename)
    assert not list((disk / "kept").glob("*.tmp"))
    enlarge()
    again().close()
