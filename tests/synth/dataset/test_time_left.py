"""How long a sweep still takes."""

import math

import pytest

from synth.dataset.stage_seconds import bed_seconds, picture_seconds, simulation_seconds
from synth.dataset.time_left import TimeLeft


@pytest.fixture
def left(tiny_wheel):
    """One bed, two motions in it, and ten looks at each."""
    found = TimeLeft()
    found.expect("bed", "b", tiny_wheel)
    for motion in "mn":
        found.expect("simulation", motion, tiny_wheel)
        for look in range(10):
            found.expect("pictures", f"{motion}{look}", tiny_wheel)
    return found


def test_nothing_is_told_before_each_stage_that_is_left_has_shown_what_it_takes(left):
    assert math.isnan(left.seconds(1))
    left.finish("bed", "b", 100.0)
    assert math.isnan(left.seconds(1))
    left.finish("simulation", "m", 40.0)
    assert math.isnan(left.seconds(1))
    left.finish("pictures", "m0", 2.0)
    # The bed's 100 s do not come again: 40 s of a motion and 19 looks of 2 s.
    assert left.seconds(1) == pytest.approx(78)
    assert left.seconds(2) == pytest.approx(39)
    assert math.isnan(left.seconds(0))


def test_what_was_there_or_failed_is_no_evidence(left):
    for stage, name in (("bed", "b"), ("simulation", "m")):
        left.finish(stage, name, None)
    left.finish("pictures", "m0", 2.0)
    assert math.isnan(left.seconds(1))
    left.finish("simulation", "n", None)
    assert left.seconds(1) == pytest.approx(19 * 2)


def test_larger_tasks_count_for_more(tiny_wheel):
    slower = tiny_wheel.model_copy(
        update={"timing": tiny_wheel.timing.model_copy(update={"speed_up": tiny_wheel.timing.speed_up / 4})}
    )
    found = TimeLeft()
    found.expect("simulation", "m", tiny_wheel)
    found.expect("simulation", "n", slower)
    found.finish("simulation", "m", 10.0)
    ratio = simulation_seconds(slower) / simulation_seconds(tiny_wheel)
    assert ratio > 2
    assert found.seconds(1) == pytest.approx(10 * ratio)


def test_a_motion_by_formula_takes_no_time_to_foretell(quick_sand):
    assert (simulation_seconds(quick_sand), bed_seconds(quick_sand)) == (0, 0)
    found = TimeLeft()
    for look in "ab":
        found.expect("simulation", look, quick_sand)
        found.expect("pictures", look, quick_sand)
    found.finish("simulation", "a", 0.1)
    found.finish("pictures", "a", 3.0)
    assert found.seconds(1) == pytest.approx(3.0)
    assert picture_seconds(quick_sand) > 0


def test_a_sweep_tells_what_is_left_of_it(sand_sweep, tmp_path):
    pytest.importorskip("distributed")
    from synth.dataset.execution import make_data_set

    told = []
    make_data_set(sand_sweep, tmp_path / "out", workers=1, progress=lambda *one: told.append(one))
    counts = [done for done, _, _ in told]
    assert counts == sorted(counts) and {total for _, total, _ in told} == {6}
    first = counts.index(1)
    assert all(math.isnan(left) for _, _, left in told[:first])
    lefts = [left for _, _, left in told[first:]]
    assert all(left > 0 for left in lefts[:-1]) and told[-1] == (6, 6, 0.0)
    assert lefts[0] > lefts[-2]
