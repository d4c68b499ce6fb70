"""Part of a recording photographed anew, and the error of every estimator in these pictures."""

import tempfile
from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from validation.scoring.metrics import ErrorSummary
from validation.studies.study import Findings, Row, Run, Study

if TYPE_CHECKING:
    import xarray as xr

    from synth import Footage, Recording
    from synth.scene import Scene

WRONG = "1.0"
"""px, error above which a pixel is told to be wrong; of `validation.scoring.metrics.WRONG_ABOVE`."""


@dataclass(frozen=True)
class Measurement:
    """Errors in one set of pictures.

    Attributes
    ----------
    label : str
        Says which, and names its file.
    take : callable
        Takes the pictures and measures them: lines of the study's table.
    """

    label: str
    take: Callable[[], list[Row]]


class PictureStudy(Study):
    """A study of errors in pictures. Measurements take long: each is kept as soon as it is done."""

    @abstractmethod
    def measurements(self, runs: Sequence[Run]) -> list[Measurement]:
        """What is to be measured; nothing is done before it is taken."""

    @abstractmethod
    def conclusion(self, rows: Sequence[Row]) -> str:
        """One line, with numbers, on the rows of all measurements."""

    def find(self, runs: Sequence[Run]) -> Findings:
        """Take every measurement."""
        return self.findings([row for one in self.measurements(runs) for row in one.take()])

    def findings(self, rows: list[Row]) -> Findings:
        """What the rows of all measurements say."""
        return Findings(rows, self.conclusion(rows))


def pair_count(*, quick: bool) -> int:
    """Pairs of pictures of each kind that a study measures."""
    return 1 if quick else 2


def picture_errors(
    recording: "Recording", scene: "Scene", methods: Sequence[str], *, pair_count: int
) -> dict[str, dict[str, ErrorSummary]]:
    """Errors of every method in every stratum, over the pairs in the middle of a recording.

    Parameters
    ----------
    recording : Recording
    scene : Scene
        The scene it was made with; the tables that only pictures depend on may differ.
    methods : sequence of str
        Names of estimators.
    pair_count : int
        Pairs, at most; a recording may have fewer.
    """
    from synth import Recording, render
    from validation.scoring.method_scores import score_methods

    count = min(pair_count, recording.frame_count - 1)
    first = (recording.frame_count - 1 - count) // 2
    part = Recording(recording.data.isel(frame=slice(first, first + count + 1)))
    with (
        tempfile.TemporaryDirectory() as folder,
        render(part, scene, Path(folder) / "footage") as footage,
    ):
        scores = score_methods(footage, {method: _measured(footage, method) for method in methods})
    return {method: score.strata for method, score in scores.items()}


def _measured(footage: "Footage", method: str) -> "xr.Dataset":
    """Displacement between consecutive pictures over pair, y and x: NaN where it was not measured."""
    import numpy as np
    import xarray as xr

    from soft.flow import estimate_flow
    from soft.sequence import to_grey

    fields = []
    for pair in range(footage.pair_count):
        first, second = (to_grey(footage.picture(k), name=footage.frames[k].name) for k in (pair, pair + 1))
        field = estimate_flow(first, second, method=method)
        fields.append(np.where(field.valid[..., None], field.displacement, np.nan))
    both = np.stack(fields)
    return xr.Dataset({name: (("pair", "y", "x"), both[..., k]) for k, name in enumerate("uv")})
