import numpy as np
import pytest

from synth.implements import Bucket, GrouserWheel, Shape


def test_a_disc_is_as_far_away_as_its_rim():
    distance = Shape.disc(0.1).distance_to_capsules(np.array([[0.3, 0.4], [0.0, 0.05]]))
    np.testing.assert_allclose(distance[:, 0], [0.4, -0.05])


def test_a_chain_is_touched_at_its_sides_and_ends():
    blade = Shape.chain([(0, 0), (1, 0), (1, 1)], 0.1)
    points = np.array([[0.5, 0.3], [-1.0, 0.0], [1.5, 0.5], [1.0, 2.0]])
    np.testing.assert_allclose(blade.distance_to_capsules(points).min(axis=1), [0.2, 0.9, 0.4, 0.9])
    np.testing.assert_array_equal(blade.continues, [False, True])


@pytest.mark.parametrize(("angle", "lowest"), [(0.0, -0.114), (np.pi / 2, -0.124)])
def test_lowest_point_turns_with_the_grousers(angle, lowest):
    wheel = GrouserWheel(
        kind="grouser_wheel",
        radius=0.114,
        width=0.057,
        normal_load=30.0,
        moving_mass=0.3,
        grouser_count=2,
        grouser_height=0.01,
        grouser_thickness=0.002,
    )
    assert wheel.shape.reach == pytest.approx(0.124)
    assert wheel.shape.turned(angle).lowest == pytest.approx(lowest)


def test_the_buckets_edge_is_its_lowest_and_foremost_point():
    bucket = Bucket(
        kind="bucket", width=0.1, cut_angle=30.0, blade_length=0.08, back_height=0.05, thickness=0.004
    )
    assert bucket.shape.lowest == pytest.approx(0.0, abs=1e-12)
    assert np.maximum(bucket.shape.start, bucket.shape.end)[:, 0].max() == 0.0
    assert bucket.shape.end[:, 1].max() == pytest.approx(0.04 + 0.05)
