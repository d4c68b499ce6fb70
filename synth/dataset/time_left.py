"""How long a sweep still takes, by what each of its stages has taken so far."""

import math
from collections import defaultdict

from synth.dataset.stage_seconds import STAGES
from synth.scene import AnyScene


class TimeLeft:
    """Tasks that are to be done, weighed by what they are foretold to take.

    A bed, a motion and a member's pictures take very different times, and a member is done only after all of
    its own: counting members would tell hours where minutes are left. So each stage counts by itself, and
    what it took, over what it was foretold to take, corrects what is left of it.
    """

    def __init__(self) -> None:
        self._waiting: dict[str, dict[str, float]] = defaultdict(dict)
        self._foretold: dict[str, float] = defaultdict(float)
        self._took: dict[str, float] = defaultdict(float)

    def expect(self, stage: str, name: str, scene: AnyScene) -> None:
        """Count a task in."""
        self._waiting[stage][name] = STAGES[stage](scene)

    def finish(self, stage: str, name: str, took: float | None) -> None:
        """Count a task out; `took` is None where there was nothing to do, or it failed: no evidence."""
        foretold = self._waiting[stage].pop(name)
        if took is not None:
            self._foretold[stage] += foretold
            self._took[stage] += took

    def seconds(self, workers: int) -> float:
        """With so many workers, kept busy; NaN until each of the stages that are left has shown something."""
        left = sum(self._left(stage) for stage in STAGES)
        return left / workers if workers else math.nan

    def _left(self, stage: str) -> float:
        """Of a core."""
        foretold = sum(self._waiting[stage].values())
        if not foretold:
            return 0.0
        evidence = self._foretold[stage]
        return foretold * self._took[stage] / evidence if evidence else math.nan
