"""One pass over the truth of footage, however many methods there are and things to be told of each."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np

from validation.scoring.regions import TrueRegions, true_interface, true_regions
from validation.scoring.strata import Strata, find_strata

if TYPE_CHECKING:
    import xarray as xr

    from soft import ShearInterface
    from synth import Footage

_USED = (
    "u", "v", "inertial_u", "inertial_v", "valid", "soil", "moving", "node_x", "node_y",
    "camera_u", "camera_u_low", "camera_u_high",
)  # fmt: skip
"""Of a SoilFlow: what any tally reads."""


@dataclass(frozen=True, eq=False)
class TruePair:
    """The truth about one picture pair, and what follows from it: found once, when it is first asked for.

    Attributes
    ----------
    data : xarray.Dataset
        Over `y, x`, as of `synth.Footage.truth`, in memory.
    """

    data: "xr.Dataset"
    _by_soil: dict[str, float] = field(default_factory=dict, repr=False)

    @cached_property
    def strata(self) -> Strata:
        """Which pixels belong together."""
        return find_strata(self.data)

    @cached_property
    def regions(self) -> TrueRegions:
        """Soil, its moving part, the shear interface, the line of greatest shear rate."""
        return true_regions(self.data, self.strata)

    @cached_property
    def interface(self) -> "ShearInterface":
        """The line that the analysis' clustering finds in the true speeds, alone."""
        return true_interface(self.data, self.strata)

    @property
    def camera(self) -> tuple[float, float]:
        """Displacement of resting soil by the camera's own motion, right and down, px."""
        return self.strata.camera_u, self.strata.camera_v

    @property
    def motion(self) -> np.ndarray:
        """Inertial displacement of soil, (2, H, W) px, NaN elsewhere."""
        return self.strata.motion

    def camera_by_soil(self, camera: str) -> float:
        """Give the camera's horizontal motion as the true displacement of soil tells it, px.

        Parameters
        ----------
        camera : str
            How it is found, as in `soft.to_inertial`.
        """
        if camera not in self._by_soil:
            from soft import to_inertial

            displacement = np.stack([self.data["u"].values, self.data["v"].values], axis=2)
            soil = self.data["soil"].values & self.data["valid"].values
            self._by_soil[camera] = to_inertial(displacement, soil, camera=camera).camera_u
        return self._by_soil[camera]


class Tally(Protocol):
    """Something that is told of a method over all pairs."""

    def add(self, true: TruePair, flow: "xr.Dataset") -> None:
        """Add one pair; the SoilFlow over `y, x`, in memory."""
        ...


def pass_over(
    footage: "Footage",
    flows: "Mapping[str, xr.Dataset]",
    tallies: Mapping[str, Sequence[Tally]],
    *,
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Show each pair, once read, to every tally of every method. Memory holds one pair of one method.

    Parameters
    ----------
    footage : synth.Footage
        Pictures and truth.
    flows : mapping
        A SoilFlow over `pair, y, x` for each method's name.
    tallies : mapping
        What is to be told of each method.
    progress : callable, optional
        Called with pairs done and pairs in all.
    """
    used = {name: flow[[held for held in _USED if held in flow]] for name, flow in flows.items()}
    for pair in range(footage.pair_count):
        true = TruePair(footage.truth(pair).load())
        for name, flow in used.items():
            measured = flow.isel(pair=pair).load()
            for tally in tallies[name]:
                tally.add(true, measured)
        if progress:
            progress(pair + 1, footage.pair_count)
