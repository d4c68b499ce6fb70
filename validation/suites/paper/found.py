"""What was measured of a suite, opened as it is needed."""

from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Self

import numpy as np

from validation.statistics import Interval, StatisticsError, block_bootstrap
from validation.suites.execution import is_measured, measured_file
from validation.suites.headline import BLOCK
from validation.suites.measurement_file import open_measurement
from validation.suites.paper.verdict import Variant
from validation.suites.plan import Look, Suite

if TYPE_CHECKING:
    import xarray as xr

_NOTHING = Interval(np.nan, np.nan, np.nan, 0, 0)


@dataclass(eq=False)
class Found:
    """Measurements of a suite by scene and variant; use it in a `with`.

    Attributes
    ----------
    out : Path
        The suite's folder.
    looks : tuple of Look
        Those that are measured.
    """

    out: Path
    looks: tuple[Look, ...]
    _stack: ExitStack = field(default_factory=ExitStack)
    _opened: "dict[Look, xr.Dataset]" = field(default_factory=dict)

    @classmethod
    def of(cls, suite: Suite, out: Path) -> Self:
        """All that is there."""
        return cls(out, tuple(look for look in suite.looks if is_measured(out, look)))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    @property
    def variants(self) -> tuple[Variant, ...]:
        """Methods and severities that something was measured with, in order."""
        every = (Variant(look.method, look.realisation.severity) for look in self.looks)
        return tuple(dict.fromkeys(every))

    def measurements(self, scene: str, variant: Variant) -> "list[xr.Dataset]":
        """One for each realisation; not to be closed."""
        return [self._open(look) for look in self.looks if _is_of(look, scene, variant)]

    def first(self, scene: str, variant: Variant, *, having: str) -> "xr.Dataset | None":
        """The first one that has a variable, in memory."""
        for measured in self.measurements(scene, variant):
            if having in measured:
                return measured.load()
        return None

    def mean(self, scene: str, variant: Variant, name: str, stratum: str | None = None) -> Interval:
        """Mean of a number that every pair has, with its interval; NaN where there is none."""
        parts = [one[name] for one in self.measurements(scene, variant) if name in one]
        if stratum is not None:
            parts = [part.sel(stratum=stratum) for part in parts]
        return mean_of([np.atleast_1d(part.values) for part in parts])

    def _open(self, look: Look) -> "xr.Dataset":
        if look not in self._opened:
            self._opened[look] = self._stack.enter_context(open_measurement(measured_file(self.out, look)))
        return self._opened[look]


def mean_of(realisations: list[np.ndarray], *, block_length: int = BLOCK) -> Interval:
    """Mean with its interval by blocks of pairs; NaN where there is no number."""
    try:
        return block_bootstrap(realisations, block_length=block_length)
    except StatisticsError:
        return _NOTHING


def _is_of(look: Look, scene: str, variant: Variant) -> bool:
    asked = scene, variant.method, variant.severity
    return (look.realisation.motion.scene, look.method, look.realisation.severity) == asked
