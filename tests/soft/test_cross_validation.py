import cv2
import numpy as np
import pytest

from soft import cross_validate, estimate_flow, soil_mask

SHAPE = (240, 320)


@pytest.fixture(scope="module")
def blobs():
    """Pictures of Gaussian blobs at given places: features whose motion is known exactly."""
    rng = np.random.default_rng(3)
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
    places = rng.uniform(0, 1, (900, 2)) * [SHAPE[1], SHAPE[0]]
    size, height = rng.uniform(1.2, 3.5, 900), rng.uniform(-60, 60, 900)

    def picture(motion):
        grey = np.full(SHAPE, 128.0)
        for (px, py), s, h in zip(motion(places), size, height, strict=True):
            grey += h * np.exp(-(np.square(x - px) + np.square(y - py)) / (2 * s * s))
        return np.clip(grey, 0, 255).astype(np.float32)

    return picture


@pytest.fixture(scope="module")
def shifted(blobs):
    """Everything by (3.3, -1.7) px."""
    return blobs(lambda p: p), blobs(lambda p: p + np.array([3.3, -1.7]))


def flow_of(u, v):
    return np.broadcast_to(np.array([u, v], np.float32), (*SHAPE, 2)).copy()


EVERYWHERE = np.ones(SHAPE, bool)


def test_sift_finds_the_motion_and_flow_agrees(shifted):
    result = cross_validate(*shifted, flow_of(3.3, -1.7), EVERYWHERE)
    assert result.keypoint_count > 300 and result.match_ratio > 0.7
    assert np.median(result.error) < 0.05
    assert result.agreement > 0.97
    assert result.unmeasured_count == 0
    assert np.allclose(np.median(result.sift, axis=0), [3.3, -1.7], atol=0.02)
    assert np.array_equal(result.agree, result.error <= 0.56)


def test_equation_7_and_the_threshold(shifted):
    right = cross_validate(*shifted, flow_of(3.3, -1.7), EVERYWHERE)
    wrong = cross_validate(*shifted, flow_of(3.3 + 0.3, -1.7 - 0.4), EVERYWHERE)
    assert np.array_equal(right.points, wrong.points)
    expected = np.hypot(*(wrong.flow - wrong.sift).T)
    assert wrong.error == pytest.approx(expected)
    assert np.median(wrong.error) == pytest.approx(0.5, abs=0.02)
    assert wrong.agreement > 0.85
    assert cross_validate(*shifted, flow_of(3.6, -2.1), EVERYWHERE, threshold=0.4).agreement < 0.15


def test_flow_is_read_at_the_nearest_pixel(shifted):
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    result = cross_validate(*shifted, np.stack([x, y], axis=-1).astype(np.float32), EVERYWHERE)
    assert np.abs(result.flow - result.points).max() <= 0.5


def test_features_lie_on_blobs():
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
    picture = 40 + 180 * np.exp(-(np.square(x - 100.2) + np.square(y - 60.7)) / (2 * 4.0**2))
    moved = 40 + 180 * np.exp(-(np.square(x - 102.2) + np.square(y - 60.7)) / (2 * 4.0**2))
    # A second, other feature: the ratio test needs something to compare with.
    other = 90 * np.exp(-(np.square(x - 220) / 18 + np.square(y - 150) / 98))
    result = cross_validate(picture + other, moved + other, flow_of(2, 0), EVERYWHERE)
    nearest = np.hypot(*(result.points - [100.2, 60.7]).T).min()
    assert nearest < 0.35


def test_unmeasured_pixels_and_the_mask(shifted):
    left = np.zeros(SHAPE, bool)
    left[:, :160] = True
    whole = cross_validate(*shifted, flow_of(3.3, -1.7), EVERYWHERE)
    half = cross_validate(*shifted, flow_of(3.3, -1.7), left)
    assert half.match_count == whole.match_count
    assert half.unmeasured_count + len(half.points) == half.match_count
    assert half.points[:, 0].max() <= 159.5
    assert f"{half.unmeasured_count} of them on pixels without a measurement" in half.remark
    masked = cross_validate(*shifted, flow_of(3.3, -1.7), EVERYWHERE, mask=left)
    assert masked.keypoint_count < 0.6 * whole.keypoint_count
    assert masked.points[:, 0].max() <= 159.5


def test_real_flow_of_a_shear(blobs):
    """Upper and lower half move apart by 3 px: DIS and SIFT agree but at the line."""
    motion = lambda p: p + np.stack([np.where(p[:, 1] < 120, 1.5, -1.5), np.zeros(len(p))], axis=1)  # noqa: E731
    first, second = blobs(lambda p: p), blobs(motion)
    field = estimate_flow(first, second, method="dis")
    result = cross_validate(first, second, field.displacement, field.valid)
    assert result.agreement > 0.85
    off = np.abs(result.points[:, 1] - 120)
    assert np.median(off[~result.agree]) < 20 < np.median(off[result.agree])


def test_nothing_to_match():
    flat = np.full(SHAPE, 100.0, np.float32)
    result = cross_validate(flat, flat, flow_of(0, 0), EVERYWHERE)
    assert result.points.shape == (0, 2) and result.keypoint_count == 0
    assert np.isnan(result.agreement) and np.isnan(result.match_ratio)
    assert "nothing to compare" in result.remark


def test_refused(shifted):
    with pytest.raises(ValueError, match="displacement: shape"):
        cross_validate(*shifted, flow_of(0, 0)[:9], EVERYWHERE)
    with pytest.raises(ValueError, match="threshold: 0: must be above 0"):
        cross_validate(*shifted, flow_of(0, 0), EVERYWHERE, threshold=0)


def test_on_any_number_of_threads(shifted):
    one, two = (cross_validate(*shifted, flow_of(3, -2), EVERYWHERE, threads=n) for n in (1, 2))
    assert np.array_equal(one.points, two.points) and np.array_equal(one.sift, two.sift)


@pytest.mark.slow
def test_tbar_flow_agrees_with_sift(real_data):
    """At half the size: the tool is no soil, and flow agrees with at least 94 % of the matches."""
    first, second = (
        cv2.resize(
            cv2.imread(str(real_data / "tbar" / f"IMG_{number}.jpg"), cv2.IMREAD_GRAYSCALE),
            None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA,
        ).astype(np.float32)
        for number in (1062, 1063)
    )  # fmt: skip
    soil = soil_mask(first).mask
    field = estimate_flow(first, second, method="dis")
    result = cross_validate(first, second, field.displacement, field.valid, mask=soil)
    assert result.match_count > 3000
    assert result.agreement >= 0.94
