"""The drawbar test, on a soil where its curves are known."""

import itertools

import pytest

from synth.rover.drawbar import STUCK, DrawbarPoint, DrawbarTest, LoadSteps
from synth.rover.gaits import Inching, Rolling
from synth.rover.law.catalogue import make_law
from synth.rover.travel_reduction import pull_at, travel_reduction, velocities
from synth.rover.vehicle import load_vehicle
from tests.synth.rover.slipping import SlippingLaw

GRIP, SPEED, COARSE = 8e3, 0.2, 0.002


def test_travel_reduction_is_equation_8():
    assert travel_reduction([0.06, 0.03, 0.0, -0.03], 0.06) == pytest.approx([0, 0.5, 1, 1.5])
    with pytest.raises(ValueError, match="does not move"):
        travel_reduction(0.01, 0.0)


def test_velocity_is_equation_9():
    assert velocities([0.0, 0.05, 0.12], 1.0) == pytest.approx([0.05, 0.07])


def test_pull_at_a_travel_reduction_is_between_points():
    assert pull_at(0.4, [0.0, 0.1, 0.2], [0.0, 0.2, 0.6]) == pytest.approx(0.15)
    assert pull_at(0.7, [0.0, 0.1, 0.2], [0.0, 0.2, 0.6]) is None


def test_rolling_loses_what_the_soil_takes(scarab):
    test = DrawbarTest(scarab, SlippingLaw(GRIP), Rolling(scarab, speed=SPEED), time_step=COARSE)
    points = list(test.points(LoadSteps(loads=(0.3,))))
    assert points[0].velocity == pytest.approx(SPEED, rel=0.01)
    lost = 0.3 * scarab.weight / (4 * GRIP)  # thrust of four wheels = grip x slip velocity
    assert points[1].travel_reduction == pytest.approx(lost / SPEED, rel=0.02)
    (phase,) = points[1].phases
    assert phase.pull == pytest.approx(0.3 * scarab.weight, rel=0.01)


def test_inching_loses_as_much_way_in_both_phases(scarab):
    gait = Inching(scarab, speed=SPEED)
    test = DrawbarTest(scarab, SlippingLaw(GRIP), gait, time_step=COARSE)
    points = list(test.points(LoadSteps(loads=(0.1,))))
    free = 0.5 / gait.cycle
    assert points[0].velocity == pytest.approx(free, rel=0.01)
    lost = 0.1 * scarab.weight / (4 * GRIP)
    assert points[1].travel_reduction == pytest.approx(lost / free, rel=0.03)
    assert [phase.phase for phase in points[1].phases] == ["expand", "contract"]
    for phase in points[1].phases:
        assert phase.duration == pytest.approx(gait.cycle / 2, abs=0.01)
        assert phase.pull == pytest.approx(0.1 * scarab.weight, rel=0.05)


def test_loads_rise_until_the_vehicle_is_stuck(scarab):
    test = DrawbarTest(scarab, SlippingLaw(2e3), Rolling(scarab, speed=0.5), time_step=COARSE)
    points = list(test.points(LoadSteps(coarse=0.7)))
    assert all(point.travel_reduction < STUCK for point in points[:-1])
    assert points[-1].travel_reduction >= STUCK
    stuck = pull_at(STUCK, [p.drawbar_pull_ratio for p in points], [p.travel_reduction for p in points])
    assert stuck == pytest.approx(STUCK * 4 * 2e3 * 0.5 / scarab.weight, rel=0.03)


def test_a_step_ends_when_the_speed_has_settled(scarab):
    test = DrawbarTest(scarab, SlippingLaw(2e3), Rolling(scarab, speed=0.05), time_step=COARSE)
    started = test.ride.time
    points = list(test.points(LoadSteps(loads=(0.9 * 4 * 2e3 * 0.05 / scarab.weight,))))
    assert points[1].travel_reduction == pytest.approx(0.9, rel=0.03)
    run_in, free, loaded = 10.0, 10.0, 12.0  # s: half a metre each, then three times four samples
    assert test.ride.time - started == pytest.approx(run_in + free + 0.5 + loaded, abs=2.5)


def test_steps_get_finer_where_a_load_takes_much():
    before = DrawbarPoint(0.1, 0.05, 0.5, ())
    points = [DrawbarPoint(0.2, 0.05, reduction, ()) for reduction in (0.51, 0.55, 0.7)]
    steps = [LoadSteps(coarse=0.04).following([before, point]) - 0.2 for point in points]
    assert steps == pytest.approx([0.04, 0.02, 0.01])


@pytest.mark.parametrize("loads", [(0.2, 0.1), (0.0,), (0.1, 0.1)])
def test_refuses_loads_that_do_not_rise(loads):
    with pytest.raises(ValueError, match="positive and rising"):
        LoadSteps(loads=loads)


def test_points_survive_json(scarab):
    test = DrawbarTest(scarab, SlippingLaw(GRIP), Rolling(scarab, speed=0.5), time_step=COARSE)
    (point,) = itertools.islice(test.points(LoadSteps()), 1)
    assert DrawbarPoint.from_dict(point.to_dict()) == point


@pytest.mark.parametrize(
    ("gait", "law", "wheel"),
    [(Inching, "rft", "pneumatic"), (Rolling, "rft", "rigid"), (Rolling, "scm", "rigid")],
)
def test_a_test_that_was_left_goes_on_to_the_bit(gait, law, wheel):
    def begin():
        vehicle = load_vehicle("scarab")
        own = make_law(law, wheel=wheel)
        return DrawbarTest(vehicle, own, gait(vehicle, speed=1.0), time_step=COARSE, cycles=1)

    steps = LoadSteps(loads=(0.04,))
    straight, left = begin(), begin()
    points = list(straight.points(steps))
    done = list(itertools.islice(left.points(steps), 1))
    taken_up = begin()
    taken_up.restore(left.state())
    assert done + list(taken_up.points(steps, done=done)) == points
    assert list(taken_up.points(steps, done=points)) == []


def test_a_law_without_a_state_cannot_be_left(scarab):
    test = DrawbarTest(scarab, SlippingLaw(GRIP), Rolling(scarab, speed=SPEED), time_step=COARSE)
    with pytest.raises(TypeError, match="SlippingLaw: has no state"):
        test.state()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("gait", "loads", "reduction"),
    [
        (Rolling, (0.12, 0.16, 0.2, 0.22, 0.24), 0.9),
        (Inching, (0.12, 0.2, 0.24), 0.2),  # beyond, it digs in by chance: see docs/scarab.md
    ],
)
def test_half_the_time_step_changes_the_pull_little(scarab, gait, loads, reduction):
    found = []
    for time_step in (0.001, 0.0005):
        test = DrawbarTest(scarab, make_law("rft"), gait(scarab), time_step=time_step)
        points = list(test.points(LoadSteps(loads=loads)))
        pulls, reductions = zip(*((p.drawbar_pull_ratio, p.travel_reduction) for p in points), strict=True)
        found.append(pull_at(reduction, pulls, reductions))
    assert found[1] == pytest.approx(found[0], rel=0.02)
