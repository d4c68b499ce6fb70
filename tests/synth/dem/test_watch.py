import pytest

from synth.dem.watch import REBUILD_AT, Watch

SKIN = 1e-4


def test_looks_twice_as_late_each_time_while_nothing_moves():
    watch, periods = Watch(SKIN), []
    for _ in range(6):
        assert not watch.list_anew(0.0, 0.0)
        periods.append(watch.left)
    assert periods == [16, 32, 64, 128, 128, 128]


@pytest.mark.parametrize("shift", [0.0, 0.2 * SKIN])
def test_the_fastest_moves_half_of_what_is_left_until_the_next_look(shift):
    reach, watch = 2e-3 * SKIN, Watch(SKIN, period=128)
    assert not watch.list_anew(shift, reach)
    assert watch.left == int(0.5 * (REBUILD_AT * SKIN - shift) / reach)


def test_lists_anew_rather_than_looking_at_every_step():
    watch = Watch(SKIN, period=128)
    assert watch.list_anew(0.39 * SKIN, 1e-3 * SKIN)
    assert watch.left == 128  # counted from the new list


def test_something_very_fast_is_looked_at_after_every_step():
    watch = Watch(SKIN)
    assert watch.list_anew(0.3 * SKIN, SKIN)
    assert watch.left == 1


def test_more_than_half_a_skin_is_too_far():
    assert not Watch(SKIN).too_far(0.49 * SKIN)
    assert Watch(SKIN).too_far(0.51 * SKIN)
