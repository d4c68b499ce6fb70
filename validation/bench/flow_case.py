"""Pictures with known motion that flow methods are measured on.

More of them: a module with functions that give a `Case`, and a list of these for `bench_flow`.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

ANALYTIC = (
    "sand_rotation",
    "sand_low_contrast",
    "sand_defocus",
    "sand_aliased",
    "shear_band",
    "sinusoidal_strain",
)
_BAND_RADIUS = 220.0
"""Of `shear_band`, px."""
_BAND_WITHIN = 12.0
"""Half the width of the ring around it that is told apart, px."""
_STRATA = ("all", "moving", "complex", "quiet")


@dataclass(frozen=True, eq=False)
class Case:
    """Two pictures, how they move, and the pixels that errors are told for.

    Attributes
    ----------
    name : str
        What rows call it.
    first, second : (H, W) float32
        Grey, 0-255.
    truth : (H, W, 2) float
        Displacement of the first picture's pixels, px.
    regions : mapping
        Name to (H, W) bool.
    soil : (H, W) bool, optional
        What to measure, for methods that keep to a mask.
    """

    name: str
    first: np.ndarray
    second: np.ndarray
    truth: np.ndarray
    regions: Mapping[str, np.ndarray]
    soil: np.ndarray | None = None


CaseSource = Callable[[], Case]
"""Makes a case when its turn has come: pictures of all of them together would fill the memory."""


def analytic_cases(names: Sequence[str] = ANALYTIC) -> list[CaseSource]:
    """Scenes whose motion is a formula, at their own seeds."""
    return [partial(_analytic, name) for name in names]


def run_cases(folders: Sequence[Path]) -> list[CaseSource]:
    """The middle picture pair of each run folder with footage."""
    return [partial(_of_run, folder) for folder in folders]


def _analytic(name: str) -> Case:
    from soft.sequence import to_grey
    from synth import picture_pair

    pair = picture_pair(name)
    regions = {"all": pair.valid}
    if name == "shear_band":
        height, width = pair.valid.shape
        y, x = np.mgrid[:height, :width]
        radius = np.hypot(x - (width - 1) / 2, y - (height - 1) / 2)
        regions["band"] = np.abs(radius - _BAND_RADIUS) < _BAND_WITHIN
        regions["inside the band"] = radius < _BAND_RADIUS - 2 * _BAND_WITHIN
    first, second = (to_grey(picture, name=name) for picture in (pair.first, pair.second))
    return Case(name, first, second, pair.displacement, regions)


def _of_run(folder: Path) -> Case:
    from soft.segmentation import soil_mask
    from soft.sequence import to_grey
    from synth.footage import Footage
    from validation.scoring.strata import find_strata

    with Footage.open(folder / "footage") as footage:
        pair = footage.pair_count // 2
        first, second = (to_grey(footage.picture(k), name=footage.frames[k].name) for k in (pair, pair + 1))
        truth = footage.truth(pair)
        displacement = np.stack([truth["u"].values, truth["v"].values], axis=-1)
        masks = find_strata(truth).masks
    regions = {name: masks[name] for name in _STRATA if masks[name].any()}
    return Case(folder.resolve().name, first, second, displacement, regions, soil_mask(first).mask)
