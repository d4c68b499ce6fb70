"""What kept error profiles tell: shares of wrong pixels, medians and biases by cause, with intervals."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from validation.statistics import Interval, StatisticsError, stratified_bootstrap
from validation.suites.headline import BLOCK

if TYPE_CHECKING:
    import xarray as xr

_FEWEST = 100
"""Pixels of a simulation in a bin; fewer say nothing."""


@dataclass(frozen=True, eq=False)
class Explained:
    """Error profiles of one method in some scenes at one severity, as they usually are seen.

    Attributes
    ----------
    profiles : xarray.Dataset
        Of `Kept`, the looks of that method.
    """

    profiles: "xr.Dataset"

    @classmethod
    def of(cls, profiles: "xr.Dataset", method: str, severity: str, scenes: Sequence[str]) -> "Explained":
        """Choose looks."""
        chosen = (
            (profiles["method"].values == method)
            & (profiles["severity"].values == severity)
            & (profiles["label"].values == "")
            & (profiles["stride"].values == 1)
            & np.isin(profiles["scene"].values, scenes)
        )
        return cls(profiles.isel(look=np.flatnonzero(chosen)))

    def share_wrong(self, explanation: str, k: int) -> Interval | None:
        """Share of the pixels of a bin that is wrong; mean over scenes. None where hardly any pixel is."""
        return self._mean(explanation, k, "wrong_count")

    def median(self, explanation: str, k: int) -> Interval | None:
        """Median error in a bin, px: mean over scenes."""
        return self._mean(explanation, k, "median")

    def bias(self, explanation: str, k: int) -> Interval | None:
        """Mean error along the true motion in a bin, px: mean over scenes."""
        return self._mean(explanation, k, "bias")

    def share_of(
        self, explanation: str, k: int, among: Sequence[int], what: str = "pixel_count"
    ) -> Interval | None:
        """Pixels of a bin (or of those the wrong ones) / those of several bins; mean over scenes."""
        own = self._counts(explanation, [k], what)
        every = self._counts(explanation, among, what)
        shares = {key: [np.array([own[key] / every[key]])] for key in own if every[key]}
        return _over_scenes(shares)

    def _counts(self, explanation: str, bins: Sequence[int], what: str) -> dict[tuple[str, int], float]:
        """Sums over the pictures of each simulation."""
        part = self._bins(explanation).isel(bin=list(bins))
        sums = part[what].sum("bin").values
        return {key: float(sums[rows].sum()) for key, rows in self._simulations().items()}

    def _mean(self, explanation: str, k: int, what: str) -> Interval | None:
        part = self._bins(explanation).isel(bin=k)
        pixels, values = part["pixel_count"].values, part[what].values.astype(np.float64)
        found = {}
        for key, rows in self._simulations().items():
            if pixels[rows].sum() >= _FEWEST:
                whole = values[rows].sum() / pixels[rows].sum() if what == "wrong_count" else None
                found[key] = [np.array([np.nanmean(values[rows]) if whole is None else whole])]
        return _over_scenes(found)

    def _bins(self, explanation: str) -> "xr.Dataset":
        return self.profiles.isel(bin=np.flatnonzero(self.profiles["explanation"].values == explanation))

    def _simulations(self) -> dict[tuple[str, int], np.ndarray]:
        """Looks of each simulation, by scene and seed."""
        keys = list(
            zip(self.profiles["scene"].values.tolist(), self.profiles["seed"].values.tolist(), strict=True)
        )
        return {key: np.flatnonzero([one == key for one in keys]) for key in dict.fromkeys(keys)}


def _over_scenes(simulations: dict[tuple[str, int], list[np.ndarray]]) -> Interval | None:
    scenes: dict[str, list[np.ndarray]] = {}
    for (scene, _), values in simulations.items():
        scenes.setdefault(scene, []).extend(values)
    try:
        return stratified_bootstrap(list(scenes.values()), block_length=BLOCK)[0]
    except StatisticsError:
        return None
