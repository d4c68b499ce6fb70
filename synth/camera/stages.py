"""How long each stage of making footage takes."""

import contextlib
import threading
import time
from collections import defaultdict
from collections.abc import Iterator


class StageClock:
    """Adds up the seconds of every stage; stages of several threads run at the same time.

    Attributes
    ----------
    seconds : dict
        By stage, in the order they were met first.
    processor_elsewhere : float
        Seconds of the processor that other processes have used for it.
    memory_elsewhere : int
        Bytes that other processes have needed at most.
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = defaultdict(float)
        self.processor_elsewhere = 0.0
        self.memory_elsewhere = 0
        self._lock = threading.Lock()

    @contextlib.contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time what happens within."""
        began = time.perf_counter()
        yield
        with self._lock:
            self.seconds[name] += time.perf_counter() - began
