"""Files in the order a person expects: `a2` before `a10`."""

import re
from pathlib import Path


def natural_key(path: Path) -> tuple[list[tuple[int, int, str]], str]:
    """Sort key of a file by its name, numbers by value, upper and lower case alike."""
    parts = re.split(r"([0-9]+)", path.name.casefold())
    # The name itself decides between `1.png` and `01.png`, so that the order never depends on the disk.
    return [(0, int(p), "") if p.isdecimal() else (1, 0, p) for p in parts], path.name
