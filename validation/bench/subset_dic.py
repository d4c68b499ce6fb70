"""Subset digital image correlation as a peer: that of pyvale (MIT), in its own process and environment.

pyvale brings Qt and VTK along, so nothing of it is imported here. The interpreter of an environment with it
(``pip install pyvale``, best alone) is named on the command line or by SOFTBED_PYVALE.
"""

from dataclasses import dataclass
from pathlib import Path

from validation.bench.flow_case import Case
from validation.bench.flow_contender import Answer
from validation.bench.peer_process import ask

_SCRIPT = Path(__file__).with_name("subset_dic_script.py")


@dataclass(frozen=True)
class SubsetDic:
    """Affine subsets of 31 px every 10 px, zero-mean normalised; pictures smoothed by 1 px, pyvale's default.

    Attributes
    ----------
    python : str or None
        The interpreter; None: not told, and so not there.
    """

    python: str | None
    name: str = "pyvale, affine subsets of 31 px, at their middles"
    own: bool = False

    def measure(self, case: Case, threads: int | None) -> Answer:
        """Vectors of the subsets' middles, forward, and the seconds they took.

        Raises
        ------
        PeerError
            It is not there, or failed.
        """
        from soft.flow.grid import Grid, GridConventions, to_field

        told = ask(self.python, _SCRIPT, case, threads, option="--pyvale", variable="SOFTBED_PYVALE")
        x, y, u, v = (told[name].astype(float) for name in ("x", "y", "u", "v"))
        grid = Grid(x, y, u, v, told["converged"] > 0)
        shape = (case.first.shape[0], case.first.shape[1])
        flow = to_field(grid, GridConventions(), shape, name=self.name)
        return Answer(flow, float(told["seconds"]), str(told["version"]))
