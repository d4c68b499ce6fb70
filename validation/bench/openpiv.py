"""OpenPIV as a peer, in its own process and environment: it is GPL, and nothing of it is imported here.

The interpreter of an environment with it (``pip install openpiv``, best alone) is named on the command line
or by SOFTBED_OPENPIV.
"""

import os
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from validation.bench.flow_case import Case
from validation.bench.flow_contender import Answer
from validation.bench.rows import PeerError

_SCRIPT = Path(__file__).with_name("openpiv_script.py")
_LONGEST = 600.0
"""s a pair, after which it is given up."""


@dataclass(frozen=True)
class OpenPiv:
    """Three passes with windows of 64, 32 and 32 px, which overlap by half, deformed symmetrically.

    Attributes
    ----------
    python : str or None
        The interpreter; None: not told, and so not there.
    """

    python: str | None
    name: str = "OpenPIV, 32 px, at its nodes"
    own: bool = False

    def measure(self, case: Case, threads: int | None) -> Answer:
        """Vectors where motion starts in the first picture, and the seconds they took.

        Symmetric deformation makes vectors those of the middle of the way; and the grid is told mirrored,
        with pixels counted from 0 (held against a rotation in `tests/validation/bench/test_openpiv.py`).

        Raises
        ------
        PeerError
            It is not there, or failed.
        """
        from soft.flow.grid import Grid, GridConventions, to_field

        told = self._run(case, threads)
        x, y, u, v, flags = (told[name].astype(float).ravel() for name in ("x", "y", "u", "v", "flags"))
        grid = Grid(x, y, u, v, flags == 0)
        conventions = GridConventions(convention="midpoint", y="mirrored")
        shape = (case.first.shape[0], case.first.shape[1])
        flow = to_field(grid, conventions, shape, name=self.name)
        return Answer(flow, float(told["seconds"]), str(told["version"]))

    def _run(self, case: Case, threads: int | None) -> dict[str, np.ndarray]:
        if self.python is None:
            raise PeerError("no interpreter with it is named (--openpiv PYTHON, or SOFTBED_OPENPIV)")
        with tempfile.TemporaryDirectory() as name:
            paths = [Path(name) / file for file in ("first.npy", "second.npy", "grid.npz")]
            for path, picture in zip(paths, (case.first, case.second), strict=False):
                np.save(path, picture)
            command = [self.python, "-I", str(_SCRIPT), *map(str, paths)]
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
                raise PeerError(f"{self.python}: {error}") from error
            if done.returncode != 0:
                words = done.stderr.strip().splitlines() or ["no word of why"]
                raise PeerError(f"{self.python}: {words[-1]}")
            with np.load(paths[-1]) as grid:
                return dict(grid)
