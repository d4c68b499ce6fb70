"""Pictures of a realisation taken, looked at by each method, and its errors kept pair by pair."""

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from validation.scoring.error_profile import error_profile
from validation.scoring.metrics import WRONG_ABOVE, ErrorSummary
from validation.scoring.modulation import response_sums
from validation.scoring.score import score_pair
from validation.scoring.strata import STRATA
from validation.scoring.truth_pass import TruePair
from validation.suites.worst_place import worst_place

if TYPE_CHECKING:
    import xarray as xr

    from synth import Footage, Recording
    from validation.suites.plan import Realisation

SCHEMA_VERSION = 1
Further = Callable[["Footage", "xr.Dataset"], "xr.Dataset"]
"""What else is measured: from footage and a SoilFlow of its first pairs, variables of names of their own."""
_QUANTITIES = {
    "pixel_count": "pixels of the stratum, measured or not",
    "coverage": "share of them that was measured",
    "median": "median end-point error",
    "mean": "mean end-point error",
    "p95": "end-point error that 95 % of the pixels do not exceed",
    "rmse": "root of the mean squared end-point error",
    "bias_u": "mean error to the right",
    "bias_v": "mean error downwards",
}
_IN_MEMORY = 4
"""Picture pairs; a longer soil flow lies in a file meanwhile, and so does the truth."""
_UNITS = {"pixel_count": "1", "coverage": "1"}


def photograph(
    recording: "Recording", realisation: "Realisation", folder: Path, *, threads: int
) -> "Footage":
    """Take the pictures of a realisation, with their truth, into a fresh folder."""
    from synth import Recording, render
    from synth.scene import AnalyticScene

    scene = realisation.scene()
    part = recording
    if not isinstance(scene, AnalyticScene):  # whose frames are a formula's, all of them
        frames = [frame for frame in realisation.frames if frame < recording.frame_count]
        part = Recording(recording.data.isel(frame=frames))
    return render(part, scene, folder, threads=threads)


def remembered_truth(footage: "Footage") -> Callable[[int], TruePair]:
    """The truth about each pair, and what follows from it; of the last few pairs in memory."""
    return lru_cache(maxsize=_IN_MEMORY)(lambda pair: TruePair(footage.truth(pair)))


def measure(
    footage: "Footage",
    method: str,
    *,
    truth: Callable[[int], TruePair] | None = None,
    pair_count: int | None = None,
    periods: np.ndarray | None = None,
    further: Sequence[str] = (),
    scratch: Path,
    threads: int,
    keep: Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> "xr.Dataset":
    """Analyze footage with a method and score it pair by pair.

    Parameters
    ----------
    truth : callable, optional
        The truth about a pair of the footage; `remembered_truth` of it for several methods in turn.
    pair_count : int, optional
        Only so many of its pairs, from the first on.
    periods : (W,) array, optional
        Of footage whose strain alternates: its period in each column, px. Then the response is kept, too.
    further : sequence of str
        What else is measured, `package.module:function` each, a `Further`.
    scratch : Path
        A folder that the soil flow lies in meanwhile.
    keep : Path, optional
        Where each pair's flow is kept until this is done, as `soft.analyze` takes it; to be removed then.

    Returns
    -------
    xarray.Dataset
        Over `pair` and `stratum`: the errors, and `wrong_share` over `bound`, too; over `pair`:
        `seconds`, processor time of the flow's estimate on `threads` threads; and of dense methods the error
        profile, summed over the pairs, and what is around the place where the method fails most.
    """
    import soft

    truth = truth or remembered_truth(footage)
    count = min(pair_count or footage.pair_count, footage.pair_count)
    sequence = soft.ImageSequence.open(footage.folder).select(stop=count + 1)
    clock = _Clock()
    path = scratch / "flow.nc" if count > _IN_MEMORY else None
    with soft.analyze(
        sequence, method=method, threads=threads, path=path, keep=keep, progress=progress
    ) as flow:
        seconds = clock.running_share() * flow.attrs["seconds_per_pair"]
        scores, profiles, places, responses = [], [], [], []
        for pair in range(count):
            true, measured = truth(pair), flow.isel(pair=pair).load()
            scores.append(score_pair(true, measured))
            if "node_x" not in measured:  # a grid's nodes are too few to be sorted
                profiles.append(error_profile(true, measured))
                places.append(worst_place(footage.picture(pair), true, measured))
            if periods is not None:
                responses.append(response_sums(true.data, measured, periods))
        facts = {name: flow.attrs[name] for name in ("method", "options", "versions")}
        others = [_imported(name)(footage, flow) for name in further]
    if path is not None:
        path.unlink()
    found = _table(scores, seconds)
    if places:
        worst = max(places, key=lambda place: place.attrs["worst_mean"])
        found = found.merge(sum(profiles[1:], profiles[0])).merge(worst)
        facts |= worst.attrs
    if responses:
        found = found.merge(sum(responses[1:], responses[0]))
    for other in others:
        found = found.merge(other)
        facts |= other.attrs
    return found.assign_attrs(facts)


def _imported(name: str) -> Further:
    module, _, function = name.partition(":")
    return getattr(import_module(module), function)


class _Clock:
    """Tells for which share of the time since it was made this process, and those it waited for, ran.

    Other processes of a suite, and whatever else the machine does, keep a method waiting; that is not its
    own time.
    """

    def __init__(self) -> None:
        self._began = self._now()

    def running_share(self) -> float:
        wall, processor = (now - began for now, began in zip(self._now(), self._began, strict=True))
        return processor / max(wall, 1e-9)

    @staticmethod
    def _now() -> tuple[float, float]:
        used = os.times()
        children = used.children_user + used.children_system
        return time.perf_counter(), used.user + used.system + children


def _table(scores: "Sequence[dict[str, ErrorSummary]]", seconds: float) -> "xr.Dataset":
    import xarray as xr

    rows = [[asdict(score[stratum]) for stratum in STRATA] for score in scores]
    variables: dict[str, tuple[tuple[str, ...], np.ndarray, dict[str, str]]] = {
        name: (
            ("pair", "stratum"),
            _numbers(rows, name),
            {"units": _UNITS.get(name, "px"), "long_name": told},
        )
        for name, told in _QUANTITIES.items()
    }
    wrong = np.stack(
        [[[_number(r["wrong_share"][str(b)]) for b in WRONG_ABOVE] for r in row] for row in rows]
    )
    told = {"units": "1", "long_name": "share of pixels above the bound, or not measured"}
    variables["wrong_share"] = (("pair", "stratum", "bound"), wrong, told)
    told = {"units": "s", "long_name": "processor time of the flow's estimate a pair"}
    variables["seconds"] = (("pair",), np.full(len(rows), seconds), told)
    coordinates = {"stratum": list(STRATA), "bound": list(WRONG_ABOVE)}
    return xr.Dataset(variables, coordinates)


def _numbers(rows: list[list[dict]], name: str) -> np.ndarray:
    return np.array([[_number(row[name]) for row in pair] for pair in rows])


def _number(value: float | None) -> float:
    return np.nan if value is None else float(value)
