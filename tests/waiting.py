"""Waiting for what other processes do, however busy the machine is."""

import time
from collections.abc import Callable
from pathlib import Path

PATIENCE = 300
"""s."""


def wait_for(happened: Callable[[], bool]) -> None:
    """Wait until something has happened; fail where it does not."""
    end = time.monotonic() + PATIENCE
    while not happened():
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.02)


def runs(process: int) -> bool:
    """Whether a process is neither gone, also while we look, nor waiting to be buried."""
    try:
        return Path(f"/proc/{process}/stat").read_text().split()[2] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False
