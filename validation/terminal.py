"""How the command line talks: results on standard output, everything else on standard error."""

import contextlib
import json
import math
import sys
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, Protocol

from synth.devices import standard_output_to_error
from synth.disk import system_complaint

if TYPE_CHECKING:
    from rich.console import RenderableType


class Progress(Protocol):
    """Told of work done and of work in all.

    Who knows how long it still takes says so, in s, NaN for not known yet; else it is guessed from how fast
    the work went.
    """

    def __call__(self, done: int, total: int, left: float | None = None, /) -> None:
        """Take note."""
        ...


_COLUMNS = 110
_SECONDS_BETWEEN_LINES = 10.0
_SECONDS_BETWEEN_LINES_AT_MOST = 120.0
_FIRST_GUESS = 0.05
"""Share of the work before which the time left is not guessed: compiling kernels comes first."""


class Terminal:
    """What a command says while it works and when it is done.

    Parameters
    ----------
    json : bool
        Keep standard output for one JSON document. Whatever libraries print there goes to standard error,
        even from compiled code.
    prefix : str
        Stands before every line: whose of several that work at once it is.
    """

    def __init__(self, *, json: bool = False, prefix: str = "") -> None:
        self.json = json
        self.prefix = prefix

    def say(self, line: str) -> None:
        """One plain line about the work."""
        print(self.prefix + line, file=sys.stderr, flush=True)  # noqa: T201 - this is where lines are printed

    def show(self, result: "RenderableType") -> None:
        """Show a result to a person; silent where the JSON document takes its place."""
        if self.json:
            return
        from rich.console import Console

        width = None if sys.stdout.isatty() else 110
        console = Console(file=sys.stdout, width=width, highlight=False)
        console.print(result, markup=False, soft_wrap=isinstance(result, str))

    def give(self, document: dict[str, Any]) -> None:
        """Print the JSON document, where one was asked for."""
        if self.json:
            print(json.dumps(document, indent=1, allow_nan=False))  # noqa: T201

    @contextlib.contextmanager
    def working(self) -> Iterator[None]:
        """While inside, nothing but JSON can reach standard output if that is what it is kept for."""
        if not self.json:
            yield
            return
        with standard_output_to_error(), contextlib.redirect_stdout(sys.stderr):
            yield

    @contextlib.contextmanager
    def progress(self, label: str) -> Iterator[Progress]:
        """Tell of one piece of work: a bar with the time left on a terminal, a few lines elsewhere."""
        bar = sys.stderr.isatty() and not self.prefix  # bars of several would overwrite each other
        with _bar(label) if bar else _lines(label, self.say) as advance:
            yield advance


@contextlib.contextmanager
def _bar(label: str) -> Iterator[Progress]:
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Task,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )
    from rich.progress import Progress as Bars
    from rich.text import Text

    class Left(TimeRemainingColumn):
        def render(self, task: Task) -> Text:
            if (left := task.fields["left"]) is None:
                return super().render(task)
            return Text(_told(left) or "-:--:--", "progress.remaining")

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        Left(),
    )
    with Bars(*columns, console=Console(file=sys.stderr)) as bars:
        task = bars.add_task(label, total=None, left=None)

        def advance(done: int, total: int, left: float | None = None, /) -> None:
            bars.update(task, completed=done, total=total, left=left)

        yield advance


@contextlib.contextmanager
def _lines(label: str, say: Callable[[str], None]) -> Iterator[Progress]:
    started = time.monotonic()
    spoken, pause, guess = started, _SECONDS_BETWEEN_LINES, _Guess(started)
    say(f"{label} ...")

    def advance(done: int, total: int, left: float | None = None, /) -> None:
        nonlocal spoken, pause
        now = time.monotonic()
        guessed = guess.seconds(now, done, total)
        if done < total and now - spoken > pause:
            told = _told(guessed if left is None else left)
            say(f"{label}: {done} of {total}{f', about {told} left' if told else ''}")
            spoken, pause = now, min(2 * pause, _SECONDS_BETWEEN_LINES_AT_MOST)

    yield advance
    say(f"{label}: done in {duration(time.monotonic() - started)}")


class _Guess:
    """The time left, from how fast work went; what was done before it was first told of does not count."""

    def __init__(self, started: float) -> None:
        self._started = started
        self._before: int | None = None

    def seconds(self, now: float, done: int, total: int) -> float:
        if self._before is None:
            self._before = done
            self._started = now if done else self._started
        gained = done - self._before
        if gained <= _FIRST_GUESS * (total - self._before):
            return math.nan
        return (now - self._started) * (total - done) / gained


def _told(left: float) -> str:
    """A time left, or nothing where it is not known."""
    return duration(left) if math.isfinite(left) else ""


def duration(seconds: float) -> str:
    """Seconds as a person says them.

    >>> duration(4.21), duration(75), duration(7300)
    ('4.2 s', '1 min 15 s', '2 h 1 min')
    """
    if seconds < 9.95:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"


def error_line(error: BaseException) -> str:
    """What an error says, in one line; its type where it says nothing."""
    text = system_complaint(error) or str(error) or type(error).__name__
    return " ".join(text.split())
