"""All that is told of methods by the truth, in one pass over it."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from validation.scoring.averaging import AveragingTally
from validation.scoring.camera import CameraTally
from validation.scoring.regions import RegionTally
from validation.scoring.score import MethodScore, StratumTally, require_all_match
from validation.scoring.truth_pass import Tally, pass_over

if TYPE_CHECKING:
    import xarray as xr

    from synth import Footage


def score_methods(
    footage: "Footage",
    flows: "Mapping[str, xr.Dataset]",
    *,
    seconds: Mapping[str, float | None] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, MethodScore]:
    """Score every method: errors, the camera's motion, regions and their lines, what averaging does.

    Parameters
    ----------
    footage : synth.Footage
        Pictures and truth.
    flows : mapping
        A SoilFlow over `pair, y, x` for each method's name.
    seconds : mapping, optional
        Wall time of the analysis a pair, by method, where it is known.
    progress : callable, optional
        Called with pairs done and pairs in all.

    Raises
    ------
    ScoreError
        A flow is not of this footage: another size, other pairs.
    """
    require_all_match(footage, flows)
    tallies = {name: _Tallies(flow) for name, flow in flows.items()}
    pass_over(footage, flows, {name: one.all for name, one in tallies.items()}, progress=progress)
    return {name: one.result((seconds or {}).get(name)) for name, one in tallies.items()}


class _Tallies:
    """What is told of one method; a part that its SoilFlow has not the variables for is left out."""

    def __init__(self, flow: "xr.Dataset") -> None:
        self._strata = StratumTally()
        self._camera = CameraTally.of(flow)
        self._regions = RegionTally() if RegionTally.suits(flow) else None
        self._averaging = AveragingTally() if AveragingTally.suits(flow) else None

    @property
    def all(self) -> list[Tally]:
        parts = (self._strata, self._camera, self._regions, self._averaging)
        return [part for part in parts if part is not None]

    def result(self, seconds: float | None) -> MethodScore:
        return MethodScore(
            seconds,
            self._strata.result(),
            camera=self._camera.result(),
            regions=None if self._regions is None else self._regions.result(),
            averaging=None if self._averaging is None else self._averaging.result(),
        )
