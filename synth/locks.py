"""Locks on files: what several processes want is made by one of them, be they on different machines."""

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def locked(path: Path, *, wait: bool) -> Iterator[int | None]:
    """Hold a lock on a file that is made for it; None where another has it and waiting is not wanted.

    The lock ends with its process, however that ends. A file rather than a folder: network file systems lock
    only what is open for writing. Who had the lock may have removed the file before leaving: then a fresh one
    is needed.
    """
    while True:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        except FileNotFoundError:
            continue
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
            if not _is_at(path, handle):
                continue
            yield handle
            return
        except BlockingIOError:
            yield None
            return
        finally:
            os.close(handle)


@contextmanager
def sole_maker(path: Path) -> Iterator[None]:
    """Be the only one who makes the file `path`; others wait. Look, once in, whether it is there by now."""
    lock = path.with_name(f".{path.name}.lock")
    with locked(lock, wait=True):
        try:
            yield
        finally:
            lock.unlink(missing_ok=True)


def _is_at(path: Path, handle: int) -> bool:
    try:
        return os.path.samestat(path.stat(), os.fstat(handle))
    except FileNotFoundError:
        return False
