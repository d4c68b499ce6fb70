"""OpenPIV as a peer, in its own process and environment: it is GPL, and nothing of it is imported here.

The interpreter of an environment with it (``pip install openpiv``, best alone) is named on the command line
or by SOFTBED_OPENPIV.
"""

from dataclasses import dataclass
from pathlib import Path

from validation.bench.flow_case import Case
from validation.bench.flow_contender import Answer
from validation.bench.peer_process import ask

_SCRIPT = Path(__file__).with_name("openpiv_script.py")


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

        told = ask(self.python, _SCRIPT, case, threads, option="--openpiv", variable="SOFTBED_OPENPIV")
        x, y, u, v, flags = (told[name].astype(float).ravel() for name in ("x", "y", "u", "v", "flags"))
        grid = Grid(x, y, u, v, flags == 0)
        conventions = GridConventions(convention="midpoint", y="mirrored")
        shape = (case.first.shape[0], case.first.shape[1])
        flow = to_field(grid, conventions, shape, name=self.name)
        return Answer(flow, float(told["seconds"]), str(told["version"]))
