"""What the system says of a file that it cannot read or write, in one line."""

import errno
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath

# HDF5 says it in a paragraph, within an error of any kind.
_HDF5_REASON = re.compile(r"errno = (\d+)")
_HDF5_FILE = re.compile(r"filename = '([^']*)'")

ROOM = 1 << 18
"""Bytes that HDF5 may need for more than the values themselves, until a file is closed."""


def require_space(path: Path, size: int) -> None:
    """Make sure that a disk has room for `size` bytes more of an HDF5 file.

    HDF5 does not survive that it cannot write: the process ends with it, if only when the file is closed.

    Raises
    ------
    OSError
        As the system would raise it.
    """
    if shutil.disk_usage(path.parent).free < size + ROOM:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))


def is_inside(name: str) -> bool:
    """Whether a path that a file names stays within a folder that it is looked for in."""
    path = PurePosixPath(name)
    return bool(name) and not path.is_absolute() and ".." not in path.parts and "\0" not in name


@contextmanager
def naming(path: Path) -> Iterator[None]:
    """Name the file in what the system says, which does so only where a file cannot be opened."""
    try:
        yield
    except OSError as error:
        error.filename = error.filename or str(path)
        raise


@contextmanager
def written_whole(path: Path, *, draft: Path | None = None) -> Iterator[Path]:
    """Let a file appear, or change, only when all of it is on the disk.

    Gives a path to write to, with the same suffix. It takes the place of `path` when the block ends well, and
    is gone otherwise, so that a full disk gets its bytes back. Folders are made. What the system says of the
    draft is said of `path`.

    Parameters
    ----------
    draft : Path, optional
        Where to write until then, on the same file system: in a work folder that is cleared of what killed
        processes leave. Default: beside `path`, of another name in every process.
    """
    draft = draft or path.with_name(f".partial-{os.getpid()}-{path.name}")
    for folder in (draft.parent, path.parent):
        folder.mkdir(parents=True, exist_ok=True)
    try:
        yield draft
        with draft.open("rb") as file:
            os.fsync(file.fileno())  # else the name may get to the disk before the bytes
        draft.replace(path)
    except OSError as error:
        if error.filename is None or str(error.filename) == str(draft):
            error.filename, error.filename2 = str(path), None
        raise
    finally:
        draft.unlink(missing_ok=True)


def system_complaint(error: BaseException) -> str | None:
    """File and reason, `truth.nc: No space left on device`; None of an error that is not the system's."""
    told = _HDF5_REASON.search(str(error))
    if told is not None:
        reason, file = os.strerror(int(told[1])), _HDF5_FILE.search(str(error))
        return f"{file[1]}: {reason}" if file else reason
    if not isinstance(error, OSError) or not error.strerror:
        return None
    return " ".join(
        f"{error.filename}: {error.strerror}".split() if error.filename else error.strerror.split()
    )
