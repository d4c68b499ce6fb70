"""`SHA256SUMS`: what every file of a folder must be, in the form that `sha256sum --check` reads."""

import hashlib
import re
from pathlib import Path

CHECKSUM_FILE = "SHA256SUMS"
_LINE = re.compile(r"([0-9a-f]{64})  (.+)")


def write_checksums(folder: Path) -> None:
    """List every file below `folder`."""
    names = sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())
    lines = [f"{file_digest(folder / name)}  {name}\n" for name in names if name != CHECKSUM_FILE]
    (folder / CHECKSUM_FILE).write_text("".join(lines), encoding="utf-8")


def read_checksums(folder: Path) -> dict[str, str]:
    """SHA-256 (hexadecimal) by path within `folder`.

    Raises
    ------
    ValueError
        A line that is none of this form.
    """
    path = folder / CHECKSUM_FILE
    found = {}
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
        match = _LINE.fullmatch(line)
        if not match:
            raise ValueError(f"{path}: line {number}: 64 hexadecimal digits, 2 spaces, a path are needed")
        found[match[2]] = match[1]
    return found


def file_digest(path: Path) -> str:
    """SHA-256 of a file's bytes, hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
