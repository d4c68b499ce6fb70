import numpy as np
import pytest

from soft import trace_streamlines

SHAPE = (120, 160)
Y, X = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
EVERYWHERE = np.ones(SHAPE, bool)


def test_uniform_flow_is_straight_and_runs_its_way():
    found = trace_streamlines(np.stack([np.full(SHAPE, 3.0), np.full(SHAPE, -4.0)], axis=-1), EVERYWHERE)
    assert len(found.lines) >= 5
    for line in found.lines:
        steps = np.diff(line, axis=0)
        assert steps == pytest.approx(np.broadcast_to([0.6, -0.8], steps.shape))


def test_rotation_gives_circles():
    displacement = np.stack([-0.05 * (Y - 60), 0.05 * (X - 80)], axis=-1)
    for line in trace_streamlines(displacement, EVERYWHERE, spacing=12).lines:
        radius = np.hypot(line[:, 0] - 80, line[:, 1] - 60)
        assert np.ptp(radius) < 0.01
        # From right to down: clockwise in the picture.
        turn = np.diff(np.unwrap(np.arctan2(line[:, 1] - 60, line[:, 0] - 80)))
        assert (turn > 0).all()


def test_stagnation_flow_gives_hyperbolas():
    displacement = np.stack([0.1 * (X - 80), -0.1 * (Y - 60)], axis=-1)
    lines = trace_streamlines(displacement, EVERYWHERE, spacing=15).lines
    assert lines
    for line in lines:
        product = (line[:, 0] - 80) * (line[:, 1] - 60)
        assert np.ptp(product) < 0.02 * max(1.0, np.abs(product).max())


def test_ends_at_what_was_not_measured_and_where_slow():
    displacement = np.stack([np.where(X < 120, 2.0, 0.05), np.zeros(SHAPE)], axis=-1)
    measured = X >= 30
    lines = trace_streamlines(displacement, measured).lines
    assert lines
    for line in lines:
        assert line[:, 0].min() >= 30 and line[:, 0].max() <= 120
    assert trace_streamlines(displacement, np.zeros(SHAPE, bool)).lines == ()


def test_slower_soil_is_left_out_as_asked():
    displacement = np.stack([X / 40, np.zeros(SHAPE)], axis=-1)  # 1 px at x = 40, 3 px at x = 120
    starts = [
        min(line[:, 0].min() for line in trace_streamlines(displacement, EVERYWHERE, least_speed=least).lines)
        for least in (1.0, 3.0)
    ]
    assert starts == pytest.approx([40, 120], abs=1)


def test_lines_are_followed_no_further_than_asked():
    displacement = np.stack([np.full(SHAPE, 3.0), np.zeros(SHAPE)], axis=-1)
    lengths = {
        longest: max(
            np.ptp(line[:, 0]) for line in trace_streamlines(displacement, EVERYWHERE, longest=longest).lines
        )
        for longest in (25.0, np.inf)
    }
    assert lengths[25.0] == pytest.approx(50, abs=1)  # each way
    assert lengths[np.inf] > 140


def test_lines_keep_their_distance():
    displacement = np.stack([np.ones(SHAPE), 0.3 * np.sin(X / 15)], axis=-1)
    lines = trace_streamlines(displacement, EVERYWHERE, spacing=16).lines
    assert len(lines) >= 5
    for k, one in enumerate(lines):
        for other in lines[k + 1 :]:
            gaps = np.hypot(*(one[:, None] - other[None]).transpose(2, 0, 1))
            assert gaps.min() >= 8


def test_refused():
    with pytest.raises(ValueError, match="spacing: 0"):
        trace_streamlines(np.zeros((*SHAPE, 2)), EVERYWHERE, spacing=0)
    with pytest.raises(ValueError, match="least_speed: -1"):
        trace_streamlines(np.zeros((*SHAPE, 2)), EVERYWHERE, least_speed=-1)
    with pytest.raises(ValueError, match="measured: shape"):
        trace_streamlines(np.zeros((*SHAPE, 2)), np.ones((2, 2), bool))
