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
    scene = cases.scene()
    travelling = cases.scene(camera={"follows": "carriage"})
    assert View.of(scene, recording, 1).axis_x == pytest.approx(cases.centre[0])
    assert View.of(travelling, recording, 1).axis_x == pytest.approx(cases.centre[0] + 0.5)


@pytest.mark.parametrize("distortion", [-0.12, 0.05, 0.2])
def test_distortion_moves_the_corners_by_its_share_and_back(distortion):
    view = View(300, 200, 1e-4, 0.2, 0.1, distortion)
    half = np.hypot(300, 200) / 2
    at = view.middle[0] + half * 300 / 360.555, view.middle[1] + half * 200 / 360.555
    column, row = view.distorted(*at)
    assert np.hypot(column - at[0], row - at[1]) == pytest.approx(abs(distortion) * half, rel=1e-4)
    assert (column > at[0]) == (distortion > 0)  # a pincushion draws the corners out
    x, y = np.meshgrid(np.linspace(-5, 305, 7), np.linspace(-5, 205, 6))
    assert np.allclose(view.distorted(*view.undistorted(x, y)), (x, y), atol=1e-9)
    assert np.allclose(view.to_image(*view.to_world(x, y)), (x, y), atol=1e-9)
    wide = view.padded(20)
    assert np.allclose(np.subtract(wide.to_image(0.21, 0.095), 20), view.to_image(0.21, 0.095))


def test_the_view_in_kernels_is_the_view(taichi):
    ti = taichi
    from synth.camera import projection_kernels as projection

    there = ti.types.ndarray(dtype=ti.f64, ndim=2)

    @ti.kernel
    def project(view: projection.numbers, x: ti.f64, z: ti.f64, found: there):
        at = projection.to_image(view, x, z)
        back = projection.undistorted(view, at[0], at[1])
        found[0, 0], found[0, 1], found[1, 0], found[1, 1] = at[0], at[1], back[0], back[1]

    view = View(300, 200, 1e-4, 0.2, 0.1, 0.08)
    found = np.zeros((2, 2))
    project(projection.numbers(view.numbers), 0.211, 0.096, found)
    assert found[0] == pytest.approx(view.to_image(0.211, 0.096), abs=1e-9)
    assert found[1] == pytest.approx(view.to_ideal(0.211, 0.096), abs=1e-9)
