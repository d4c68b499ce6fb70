import numpy as np
import pytest

from synth.rover.law.ground import Tracks


def drive(tracks, xs, lowest):
    for x in xs:
        tracks.follow(np.array([x]), np.array([lowest]))


def test_a_rut_is_left_behind_the_axle_and_nowhere_else():
    tracks = Tracks([0], spacing=0.01, share=0.5)
    drive(tracks, np.arange(0, 0.501, 0.003), -0.04)
    np.testing.assert_allclose(tracks.height(np.array([[0.1, 0.3, 0.45]])), -0.02)
    np.testing.assert_array_equal(tracks.height(np.array([[-0.05, 0.55, 2.0]])), 0)


@pytest.mark.parametrize("step", [0.001, 0.007, 0.05])
def test_a_rut_does_not_depend_on_the_step(step):
    tracks = Tracks([0], spacing=0.01, share=1.0)
    drive(tracks, np.append(np.arange(0, 0.4, step), 0.4), -0.03)
    assert np.sum(tracks.profile(0)[:, 1] < 0) == 40


def test_every_pass_lowers_it_further_and_is_counted():
    tracks = Tracks([0], spacing=0.01, share=0.5)
    there = np.arange(0, 0.301, 0.01)
    for path in (there, there[::-1], there):
        drive(tracks, path, -0.04)
    assert tracks.height(np.array([[0.15]])) == pytest.approx(-0.04 * (1 - 0.5**3))
    assert tracks.passes(np.array([[0.15]])) == 3


def test_wheels_of_one_track_share_it_and_those_of_another_do_not():
    tracks = Tracks([0, 0, 1], spacing=0.01, share=1.0)
    for x in np.arange(0, 0.2, 0.005):
        tracks.follow(np.array([x + 0.5, x, x + 0.5]), np.array([-0.02, 0.5, 0.5]))
    np.testing.assert_allclose(tracks.height(np.full((3, 1), 0.6))[:, 0], [-0.02, -0.02, 0])


def test_a_track_grows_wherever_a_wheel_goes():
    tracks = Tracks([0], spacing=0.01, share=1.0)
    drive(tracks, np.arange(0, -7.0, -0.02), -0.01)
    drive(tracks, np.arange(-7.0, 9.0, 0.02), -0.02)
    profile = tracks.profile(0)
    assert profile[0, 0] < -7 and profile[-1, 0] > 9
    inside = (profile[:, 0] > -6.9) & (profile[:, 0] < 8.9)
    np.testing.assert_allclose(profile[inside, 1], -0.02)
