"""Motion there and back is compared as published, where a pixel lands, and says what is not a measurement."""

import numpy as np
import pytest

from soft.flow import BUILT_IN, FlowError, estimate_flow, find_estimator, resolve_options
from soft.flow.consistency import Check, landed, read_back

SHAPE = (40, 60)


def uniform(u, v, shape=SHAPE):
    return np.broadcast_to(np.float32([u, v]), (*shape, 2)).copy()


class TestCheck:
    def test_published_rule(self):
        """|f + b|^2 < 0.01 (|f|^2 + |b|^2) + 0.5: for f = (30, 0), b = (-30 + d, 0) the bound is 4.03 px."""
        forward = uniform(30, 0)
        bound = (-0.6 + (0.6**2 + 4 * 0.99 * 18.5) ** 0.5) / (2 * 0.99)
        assert bound == pytest.approx(4.03, abs=0.001)
        for missed, passes in ((bound - 0.01, True), (bound + 0.01, False)):
            assert Check().passed(forward, uniform(-30 + missed, 0)).all() == passes

    def test_at_rest_the_slack_is_half_a_squared_pixel(self):
        for missed, passes in ((0.710, True), (0.712, False)):
            assert Check().passed(uniform(0, 0), uniform(0, missed)).all() == passes

    def test_tolerance_is_a_length(self):
        for missed, passes in ((0.24, True), (0.26, False)):
            back = uniform(-3 + 0.6 * missed, -4 + 0.8 * missed)
            assert Check.of(0.25).passed(uniform(3, 4), back).all() == passes

    def test_what_is_not_known_does_not_pass(self):
        back = uniform(-1, 0)
        back[3, 4] = np.nan
        passed = Check().passed(uniform(1, 0), back)
        assert not passed[3, 4] and passed.sum() == passed.size - 1

    @pytest.mark.parametrize("wish", [0.0, -1.0, float("nan"), "yes", [1]])
    def test_impossible(self, wish):
        with pytest.raises(FlowError, match="forward_backward"):
            Check.of(wish)


class TestReadBack:
    def test_is_read_where_the_pixel_lands(self):
        """b grows by 1 a px to the right and by 10 a px down, so that it tells where it was read."""
        y, x = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(np.float32)
        backward = np.stack([x + 10 * y, -x], axis=2)
        back = read_back(uniform(2.5, -1.25), backward)
        assert back[20, 30] == pytest.approx([32.5 + 187.5, -32.5], abs=0.3)  # OpenCV reads at 1/32 px

    def test_nan_is_made_up_for_by_half_of_the_weight(self):
        backward = uniform(-1, 0.5)
        backward[:, 30:] = np.nan
        assert read_back(uniform(0.25, 0), backward)[20, 29] == pytest.approx([-1, 0.5])
        assert np.isnan(read_back(uniform(0.75, 0), backward)[20, 29]).all()

    def test_landed_holds_what_is_read(self):
        forward = np.full((*SHAPE, 2), np.nan, np.float32)
        forward[10, 20] = (5.4, -3.2)
        assert [tuple(ends) for ends in np.argwhere(landed(forward))[[0, -1]]] == [(5, 23), (9, 27)]


@pytest.mark.parametrize("method", sorted(BUILT_IN))
def test_every_built_in_can_check(moved, method):
    first, second, _ = moved(shift=(2.3, -0.8))
    second = second.copy()
    second[60:110, 80:140] = np.random.default_rng(0).uniform(0, 255, (50, 60))  # something else came in
    checked = estimate_flow(first, second, method=method, forward_backward=0.5)
    plain = estimate_flow(first, second, method=method, forward_backward=False)
    hidden = np.s_[68:102, 88:128]
    assert checked.valid[hidden].mean() < 0.7 * plain.valid[hidden].mean()
    assert checked.valid[20:40, 20:-20].all()
    assert np.array_equal(checked.displacement[checked.valid], plain.displacement[checked.valid])


SLOW = ("black-anandan", "robust-affine")
"""Methods with a coarser way back, which may miss the start by more px."""


@pytest.mark.parametrize("method", sorted(BUILT_IN))
def test_built_in_methods_check_unless_told_otherwise(method):
    assert resolve_options(method, {})["forward_backward"] == (2.0 if method in SLOW else True)
    assert resolve_options(method, {"forward_backward": False})["forward_backward"] is False
    assert resolve_options(method, {"forward_backward": 0.25})["forward_backward"] == 0.25


class TestWayBack:
    def test_a_function_of_the_users_own_is_asked_for_it_only_on_request(self, moved):
        first, second, _ = moved(shift=(1.5, 0))
        calls = []

        def own(a, b, mask):
            calls.append(np.array_equal(a, first))
            return uniform(1.5, 0, a.shape) if calls[-1] else uniform(-1.5, 5, a.shape)

        assert estimate_flow(first, second, method=own).valid[:, :-2].all()
        assert calls == [True]
        assert not estimate_flow(first, second, method=own, forward_backward=True).valid.any()
        assert calls == [True, True, False]

    def test_an_estimator_may_bring_its_own(self, moved, monkeypatch):
        from dataclasses import replace

        from soft.flow import estimate

        first, second, _ = moved(shift=(2.0, 0))

        def backward(a, b, forward, options):
            assert np.array_equal(a, first) and np.array_equal(b, second)
            assert np.nanmedian(forward.displacement[..., 0]) == pytest.approx(2, abs=0.1)
            answer = uniform(-2, 0, a.shape)
            answer[:, 100:] = 9
            return answer

        own = replace(find_estimator("dis"), backward=backward)
        monkeypatch.setattr(estimate, "find_estimator", lambda method: own)
        valid = estimate_flow(first, second, method="dis").valid
        assert valid[20:-20, 20:97].all() and not valid[:, 99:].any()

    def test_files_have_one_direction(self, tmp_path, moved):
        from soft.flow import write_flo

        first, second, _ = moved()
        write_flo(tmp_path / "0.flo", np.zeros((*first.shape, 2)))
        with pytest.raises(FlowError, match="knows one direction only"):
            estimate_flow(first, second, method=f"files:{tmp_path}", pair=0, forward_backward=True)
