import numpy as np
import pytest

from soft import direction_statistics, failure_depth, forward_flux, thrust_shares, velocity_profile

SHAPE = (80, 100)
Y, X = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
SOIL = Y >= 20
EVERYWHERE = np.ones(SHAPE, bool)


def field(u, v):
    return np.stack(np.broadcast_arrays(u, v, Y)[:2], axis=-1).astype(float)


class TestProfile:
    def test_linear_shear_below_a_wheel(self):
        wheel = np.hypot(X - 50, Y - 10) < 25
        soil = SOIL & ~wheel
        displacement = field(2.0 - 0.05 * (Y - 35), 0.1 * (X - 50))
        profile = velocity_profile(displacement, soil, x=50, width=5)
        assert profile.y[0] == np.flatnonzero(soil[:, 50])[0] == 35
        assert profile.depth == pytest.approx(np.arange(45))
        assert profile.u == pytest.approx(2.0 - 0.05 * profile.depth)
        assert profile.v == pytest.approx(np.zeros(45), abs=1e-12)
        assert profile.count.tolist() == [5] * 45
        assert profile.spread_v == pytest.approx(np.full(45, 0.1 * np.sqrt(2)))

    def test_what_was_not_measured_is_left_out(self):
        displacement = field(1.0, 2.0)
        displacement[40, 48:53] = np.nan
        displacement[41, 50] = np.nan
        profile = velocity_profile(displacement, SOIL, x=50.2, width=4.5)
        assert np.isnan(profile.u[20]) and profile.count[20] == 0
        assert profile.u[21] == 1.0 and profile.count[21] == 4

    def test_refused(self):
        with pytest.raises(ValueError, match="x: 200: must lie in the picture"):
            velocity_profile(field(0, 0), SOIL, x=200)
        with pytest.raises(ValueError, match="no soil in this column"):
            velocity_profile(field(0, 0), SOIL & (X > 50), x=20)


class TestThrust:
    def test_one_direction(self):
        shares = thrust_shares(field(-3.0, 4.0), EVERYWHERE)
        assert (shares.along, shares.against, shares.across) == pytest.approx((0.36, 0.0, 0.64))
        assert thrust_shares(field(-3.0, 4.0), EVERYWHERE, direction=(0, 7)).along == pytest.approx(0.64)
        assert thrust_shares(field(3.0, 4.0), EVERYWHERE).against == pytest.approx(0.36)

    def test_a_rotating_disc_has_all_directions_alike(self):
        inside = np.hypot(X - 50, Y - 40) <= 35
        shares = thrust_shares(field(-(Y - 40), X - 50), inside)
        assert (shares.along, shares.against, shares.across) == pytest.approx((0.25, 0.25, 0.5), abs=1e-3)

    def test_unknown_is_left_out_and_nothing_refused(self):
        displacement = field(-1.0, 0.0)
        displacement[:40] = np.nan
        displacement[40:60] = [0.0, 1.0]
        assert thrust_shares(displacement, EVERYWHERE).along == pytest.approx(0.5)
        with pytest.raises(ValueError, match="nothing in it moves"):
            thrust_shares(field(0, 0), EVERYWHERE)
        with pytest.raises(ValueError, match="direction"):
            thrust_shares(field(1, 0), EVERYWHERE, direction=(0, 0))


class TestDirections:
    def test_all_one_way(self):
        found = direction_statistics(field(1.0, -1.0), EVERYWHERE, bin_count=8)
        assert found.mean_direction == pytest.approx(np.pi / 4)
        assert found.resultant_length == pytest.approx(1.0)
        assert found.share.sum() == pytest.approx(1.0)
        assert found.share.max() == pytest.approx(1.0)
        k = int(np.argmax(found.share))
        assert found.edges[k] <= np.pi / 4 <= found.edges[k + 1]

    def test_every_way(self):
        inside = np.hypot(X - 50, Y - 40) <= 35
        found = direction_statistics(field(-(Y - 40), X - 50), inside, bin_count=12)
        assert found.resultant_length < 1e-9
        assert found.share == pytest.approx(np.full(12, 1 / 12), abs=0.01)

    def test_two_ways_at_an_angle(self):
        """Half to the right, half up: the mean vector is (1/2, 1/2)."""
        displacement = np.where((X < 50)[..., None], field(5.0, 0.0), field(0.0, -0.2))
        found = direction_statistics(displacement, EVERYWHERE)
        assert found.resultant_length == pytest.approx(np.sqrt(0.5))
        assert found.mean_direction == pytest.approx(np.pi / 4)
        weighed = direction_statistics(displacement, EVERYWHERE, by_speed=True)
        assert weighed.resultant_length == pytest.approx(np.hypot(5, 0.2) / 5.2)
        assert weighed.mean_direction == pytest.approx(np.arctan2(0.2, 5))

    def test_refused(self):
        with pytest.raises(ValueError, match="nothing in it moves"):
            direction_statistics(field(0, 0), EVERYWHERE)
        with pytest.raises(ValueError, match="bin_count: 0"):
            direction_statistics(field(1, 0), EVERYWHERE, bin_count=0)


class TestFlux:
    def test_a_sheet_that_moves(self):
        """30 px of soil go forward by 2 px, 30 px back by 0.5 px."""
        displacement = field(np.where(Y < 50, 2.0, -0.5), 9.0)
        flux = forward_flux(displacement, SOIL, x=60.3)
        assert (flux.forward, flux.backward, flux.net, flux.unit) == (60.0, 15.0, 45.0, "px2/frame")
        assert forward_flux(displacement, SOIL, x=60, forward=-1).forward == 15.0
        calibrated = forward_flux(displacement, SOIL, x=60, metres_per_pixel=2e-4, frame_rate=8.0)
        # 60 px2 of 0.2 mm, eight times a second.
        assert calibrated.forward == pytest.approx(60 * 0.04 * 8) and calibrated.unit == "mm2/s"

    def test_what_was_not_measured_is_told(self):
        displacement = field(1.0, 0.0)
        displacement[20:35] = np.nan
        flux = forward_flux(displacement, SOIL, x=3)
        assert (flux.forward, flux.unmeasured) == (45.0, 0.25)

    def test_refused(self):
        with pytest.raises(ValueError, match="x: -3"):
            forward_flux(field(0, 0), SOIL, x=-3)
        with pytest.raises(ValueError, match="forward: 0"):
            forward_flux(field(0, 0), SOIL, x=3, forward=0)


class TestDepth:
    def test_half_disc_below_a_wheel(self):
        wheel = np.hypot(X - 50, Y - 10) < 25  # its lowest row is 34
        soil = SOIL & ~wheel
        moving = np.hypot(X - 50, Y - 20) <= 30
        found = failure_depth(moving, soil, surface_y=20)
        assert (found.depth, found.x, found.y) == (30.5, 50.0, 50.0)
        below = failure_depth(moving & (X == 50), soil)
        assert below.depth == 16.0  # rows 35 to 50

    def test_nothing_moves(self):
        found = failure_depth(np.zeros(SHAPE, bool), SOIL)
        assert found.depth == 0 and np.isnan(found.x)
