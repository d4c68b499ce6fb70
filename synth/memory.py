"""How much memory a process takes of the machine."""

from pathlib import Path

_ROLLUP = Path("/proc/self/smaps_rollup")


def memory_share() -> int:
    """Bytes that this process holds; of what several share, a part each. 0 where the system does not tell.

    The sum over processes is what they hold together (Linux's proportional set size).
    """
    lines = _ROLLUP.read_text().splitlines() if _ROLLUP.is_file() else []
    return next((1024 * int(line.split()[1]) for line in lines if line.startswith("Pss:")), 0)
