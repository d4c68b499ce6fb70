import numpy as np
import pytest

from synth.camera.view import View

VIEW = View(width=5, height=3, metres_per_pixel=0.1, axis_x=2.0, axis_z=7.0)


def test_the_optical_axis_is_in_the_middle_of_the_picture():
    assert VIEW.to_image(2.0, 7.0) == pytest.approx((2.0, 1.0))


def test_x_goes_right_and_z_goes_up():
    assert VIEW.to_image(2.1, 7.0) == pytest.approx((3.0, 1.0))
    assert VIEW.to_image(2.0, 7.1) == pytest.approx((2.0, 0.0))


def test_world_and_back_is_the_same_place():
    column, row = np.meshgrid(np.linspace(-3, 9, 5), np.linspace(-2, 6, 4))
    assert np.allclose(VIEW.to_image(*VIEW.to_world(column, row)), (column, row), atol=1e-12)


def test_a_counter_clockwise_turn_goes_from_x_towards_minus_y():
    angle = 0.3
    start, end = VIEW.to_image(3.0, 7.0), VIEW.to_image(2.0 + np.cos(angle), 7.0 + np.sin(angle))
    seen = np.arctan2(end[1] - 1.0, end[0] - 2.0) - np.arctan2(start[1] - 1.0, start[0] - 2.0)
    assert seen == pytest.approx(VIEW.angle_to_image(angle))


def test_the_bounds_are_the_outer_edges_of_the_outer_pixels():
    assert VIEW.bounds() == pytest.approx((1.75, 2.25, 6.85, 7.15))


def test_a_travelling_camera_adds_the_carriage_and_a_fixed_one_does_not(cases):
    still = np.zeros((2, 1))
    recording = cases.recording(still, still, carriage=[0.0, 0.5])
    camera = cases.scene().camera
    travelling = camera.model_copy(update={"follows": "carriage"})
    assert View.of(camera, recording, 1).axis_x == pytest.approx(cases.centre[0])
    assert View.of(travelling, recording, 1).axis_x == pytest.approx(cases.centre[0] + 0.5)
