"""What is left to do of a frame is done in a thread of its own, while the next one is rendered."""

import queue
import threading
from collections.abc import Callable
from types import TracebackType
from typing import Self

_WAITING = 2
"""Tasks that may wait: bounds the memory, and is enough to keep the thread busy."""


class BackgroundWriter:
    """Runs tasks in order in one thread; an error in a task comes up at the next call, or at the end."""

    def __init__(self) -> None:
        self._tasks: queue.Queue[Callable[[], None] | None] = queue.Queue(_WAITING)
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._work, name="footage writer", daemon=True)
        self._thread.start()

    def put(self, task: Callable[[], None]) -> None:
        """Do a task as soon as those before it are done."""
        self._raise()
        self._tasks.put(task)

    def _work(self) -> None:
        while (task := self._tasks.get()) is not None:
            if self._error is None:
                try:
                    task()
                except BaseException as error:
                    self._error = error

    def _raise(self) -> None:
        if self._error is not None:
            raise self._error

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._tasks.put(None)
        self._thread.join()
        if kind is None:
            self._raise()
