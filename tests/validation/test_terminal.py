"""What is said of the time left."""

import math
from types import SimpleNamespace

import pytest

from validation import terminal
from validation.terminal import Terminal


@pytest.fixture
def clock(monkeypatch):
    """A clock that is set by hand."""
    clock = SimpleNamespace(now=0.0)
    monkeypatch.setattr(terminal.time, "monotonic", lambda: clock.now)
    return clock


@pytest.fixture
def told(clock, capsys):
    """Lines that are said while work is done: (at s, done, total, left) each."""

    def tell(*steps):
        clock.now = 0.0
        with Terminal().progress("work") as progress:
            for now, *step in steps:
                clock.now = now
                progress(*step)
        return capsys.readouterr().err.splitlines()[1:-1]

    return tell


def test_it_is_guessed_from_how_fast_work_went(told):
    lines = told((0, 0, 100), (11, 5, 100), (40, 10, 100), (100, 20, 100))
    assert lines == [
        "work: 5 of 100",
        "work: 10 of 100, about 6 min 0 s left",
        "work: 20 of 100, about 6 min 40 s left",
    ]


def test_what_was_there_before_does_not_count(told):
    """90 of 100 were there: the next one took 20 s, so the last nine take 180."""
    assert told((0, 90, 100), (20, 91, 100)) == ["work: 91 of 100, about 3 min 0 s left"]
    assert told((30, 600, 1000), (60, 700, 1000)) == [
        "work: 600 of 1000",
        "work: 700 of 1000, about 1 min 30 s left",
    ]


def test_who_knows_it_says_it(told):
    assert told((20, 1, 9, math.nan), (60, 8, 9, 500.0)) == [
        "work: 1 of 9",
        "work: 8 of 9, about 8 min 20 s left",
    ]


@pytest.mark.parametrize(("left", "shown"), [(math.nan, "-:--:--"), (75.0, "1 min 15 s")])
def test_bar_shows_it(capsys, monkeypatch, left, shown):
    monkeypatch.setattr(terminal.sys.stderr, "isatty", lambda: True, raising=False)
    with Terminal().progress("work") as progress:
        progress(1, 9, left)
    assert shown in capsys.readouterr().err
