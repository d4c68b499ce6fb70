import numpy as np
import pytest

from soft import CameraSpeed, ImageSequence, analyze, camera_speed


def test_as_the_paper_tells_it():
    """Section 3.1.2: 0.79 cm/s +- 0.04 cm/s are 7.23 +- 0.34 px a frame."""
    rng = np.random.default_rng(0)
    u = rng.normal(size=50)
    u = -7.23 + 0.34 / 1.96 * (u - u.mean()) / u.std(ddof=1)
    speed = CameraSpeed.of(u, None, metres_per_second=0.0079 / 7.23)
    assert (speed.u, speed.u_range) == pytest.approx((-7.23, 0.34))
    assert speed.along == pytest.approx((0.0079, 0.00037), rel=1e-2)
    assert str(speed) == (
        "resting soil -7.230 ± 0.340 px a pair (95 % of 50 pairs): camera 0.790 ± 0.037 cm/s to the right"
    )


def test_what_rounds_to_nothing_has_no_sign():
    speed = CameraSpeed.of(np.array([-1e-5, 2e-5]), None, metres_per_second=1e-4)
    assert "-0.000" not in str(speed)


def test_pairs_without_soil_do_not_count():
    speed = CameraSpeed.of(np.array([np.nan, 2.0, 4.0]), np.array([np.nan, 1.0, 1.0]))
    assert (speed.pair_count, speed.u, speed.v, speed.v_range) == (2, 3.0, 1.0, 0.0)
    assert speed.along is None
    assert "unknown" in str(CameraSpeed.of(np.array([np.nan]), None))


def test_of_a_soil_flow_over_any_stride(moved):
    pictures = [moved(shift=(-0.75 * k, 0.25 * k))[1] for k in range(5)]
    sequence = ImageSequence.from_arrays(pictures, metres_per_pixel=2e-4, frame_rate=8).select(stride=2)
    flow = analyze(sequence, method="farneback", soil="all", vertical=True)
    speed = camera_speed(flow)
    assert speed.pair_count == 3
    assert (speed.u, speed.v) == pytest.approx((-1.5, 0.5), abs=0.05)
    assert speed.along[0] == pytest.approx(0.75 * 8 * 2e-4, rel=0.05)
    assert flow.attrs["camera_speed"] == str(speed)
    assert np.isnan(camera_speed(analyze(sequence, method="farneback", soil="all")).v)
