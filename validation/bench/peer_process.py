"""Peers that are asked in their own process, in the environment that they are installed in."""

import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from validation.bench.flow_case import Case
from validation.bench.rows import PeerError

_LONGEST = 600.0
"""s a pair, after which it is given up."""


def ask(
    python: str | None, script: Path, case: Case, threads: int | None, *, option: str, variable: str
) -> dict[str, np.ndarray]:
    """Run `python script FIRST.npy SECOND.npy GRID.npz`, and read what GRID.npz then holds.

    Parameters
    ----------
    python : str or None
        The interpreter of the peer's environment; None: not told.
    script : Path
        What it runs; imports the peer, and nothing of this project.
    option, variable : str
        By which the interpreter is named.

    Raises
    ------
    PeerError
        It is not there, or failed.
    """
    if python is None:
        raise PeerError(f"no interpreter with it is named ({option} PYTHON, or {variable})")
    with tempfile.TemporaryDirectory() as name:
        paths = [Path(name) / file for file in ("first.npy", "second.npy", "grid.npz")]
        for path, picture in zip(paths, (case.first, case.second), strict=False):
            np.save(path, picture)
        command = [python, "-I", str(script), *map(str, paths)]
        count = {} if threads is None else {"OMP_NUM_THREADS": str(threads)}
        try:
            done = subprocess.run(
                command,
                env=os.environ | count,
                capture_output=True,
                text=True,
                timeout=_LONGEST,
                check=False,
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise PeerError(f"{python}: {error}") from error
        if done.returncode != 0:
            words = done.stderr.strip().splitlines() or ["no word of why"]
            raise PeerError(f"{python}: {words[-1]}")
        with np.load(paths[-1]) as grid:
            return dict(grid)
