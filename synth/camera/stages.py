"""How long each stage of making footage takes."""

import contextlib
import threading
import time
from collections import defaultdict
from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from synth.camera.crew_process import Summary


class StageClock:
    """Adds up the seconds of every stage; stages of several threads run at the same time.

    Attributes
    ----------
    seconds : dict
        By stage, in the order they were met first.
    elsewhere : list of Summary
        What other processes say of themselves.
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = defaultdict(float)
        self.elsewhere: list[Summary] = []
        self._lock = threading.Lock()

    @contextlib.contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time what happens within."""
        began = time.perf_counter()
        yield
        with self._lock:
            self.seconds[name] += time.perf_counter() - began

    def add(self, summary: "Summary") -> None:
        """Add what another process has spent."""
        for name, seconds in summary.seconds.items():
            self.seconds[name] += seconds
        self.elsewhere.append(summary)
