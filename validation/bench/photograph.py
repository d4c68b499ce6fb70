"""A photograph of real soil, moved by a formula: pictures that own rendering had no part in.

The photograph is made a band-limited signal on a grid twice as fine as the pictures' pixels. Both pictures
are read from it between its points, the first one too: neither holds the photograph's own pixels, and
interpolation costs both the same, next to nothing. What the signal shows moves by the formula exactly: the
second picture is read where its pixels come from. Then each gets noise of its own and is rounded to 8 bit.
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from synth.analytic.motion import Rotation, ShearBand, SimpleShear, SinusoidalStrain

if TYPE_CHECKING:
    from validation.bench.flow_case import Case, CaseSource

SENSOR_NOISE = 1.5
"""Grey levels, standard deviation; as in the analytic scenes."""
FINER = 2
"""Points of the signal along one pixel of the pictures."""
REDUCED = 2
"""Photograph's pixels, each way, that become one point of the signal: 4 x 4 make a pixel of the pictures."""
PASS, STOP = 0.20, 0.35
"""Spatial frequencies below which all is kept and above which nothing, per pixel of the pictures; a half is
Nyquist's."""
_TILT = 0.05
"""rad; the pictures' rows against the photograph's, so that pixels fall between points everywhere."""
_MARGIN = 16
"""Px of the pictures that motion may bring in from outside, and that mirroring at the border reaches."""
_ORDER = 5
"""Of the splines."""
_LEAST = 64
"""Least side of a picture, px."""

MOTIONS: Mapping[str, Rotation | SimpleShear | ShearBand | SinusoidalStrain] = {
    "rotation": Rotation(kind="rotation", angle=0.02944),
    "simple_shear": SimpleShear(kind="simple_shear", shear=0.03),
    "shear_band": ShearBand(kind="shear_band", radius=90.0, jump=6.0, scale=2.0),
    "sinusoidal_strain": SinusoidalStrain(
        kind="sinusoidal_strain", amplitude=0.5, shortest=20.0, longest=150.0, span=600.0
    ),
}
"""Motions by name, px from the pictures' middle; as strong as those of the analytic scenes, or less in the
band: these pictures are smaller."""

_BAND_WITHIN = 12.0
"""Half the width of the ring around the shear band that is told apart, px."""
_TBAR = ("tbar/IMG_1062.jpg", np.s_[100:3000, 0:1420])
"""A photograph of the test data, and its soil clear of the tool."""


@dataclass(frozen=True, eq=False)
class MovedPhotograph:
    """Two pictures and what happened between them.

    Attributes
    ----------
    first, second : (H, W) float32 array
        Grey levels 0-255, whole numbers unless they were asked for without noise.
    displacement : (H, W, 2) float32 array
        px, forward, on the first picture's pixels.
    valid : (H, W) bool array
        Where motion ends in the picture.
    """

    first: np.ndarray
    second: np.ndarray
    displacement: np.ndarray
    valid: np.ndarray


class Signal:
    """A band-limited signal that can be read anywhere.

    Parameters
    ----------
    photograph : (H, W) array
        Grey levels 0-255.

    Raises
    ------
    ValueError
        A photograph too small to make pictures of.
    """

    def __init__(self, photograph: np.ndarray) -> None:
        import cv2
        from scipy.ndimage import spline_filter

        if photograph.ndim != 2 or min(photograph.shape) < FINER * REDUCED * (_LEAST + 2 * _MARGIN):
            least = FINER * REDUCED * (_LEAST + 2 * _MARGIN)
            raise ValueError(
                f"photograph of shape {photograph.shape}: must be grey, of {least} px at least each way"
            )
        height, width = (side // REDUCED for side in photograph.shape)
        fine = photograph[: REDUCED * height, : REDUCED * width].astype(np.float32)
        reduced = cv2.resize(fine, (width, height), interpolation=cv2.INTER_AREA)
        self.points = _low_passed(reduced.astype(np.float64))
        self._coefficients = spline_filter(self.points, _ORDER, mode="mirror")

    @property
    def picture_shape(self) -> tuple[int, int]:
        """Rows and columns of pictures that stay within the signal, whatever brings soil in by the margin."""
        height, width = (side / FINER for side in self.points.shape)
        cosine, sine = np.cos(_TILT), np.sin(_TILT)
        # The largest tilted rectangle of the signal's own proportions.
        share = min(height / (height * cosine + width * sine), width / (width * cosine + height * sine))
        rows, columns = (int(share * side) - 2 * _MARGIN for side in (height, width))
        return rows, columns

    def read(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Grey levels at places told in px of the pictures from their middle; x, y, result of one shape."""
        from scipy.ndimage import map_coordinates

        cosine, sine = np.cos(_TILT), np.sin(_TILT)
        height, width = self.points.shape
        column = FINER * (cosine * x - sine * y) + (width - 1) / 2
        row = FINER * (sine * x + cosine * y) + (height - 1) / 2
        return map_coordinates(
            self._coefficients, [row, column], order=_ORDER, mode="mirror", prefilter=False
        )


def moved_photograph(
    signal: Signal,
    motion: Rotation | SimpleShear | ShearBand | SinusoidalStrain,
    *,
    noise: float | None = SENSOR_NOISE,
    seed: int = 0,
) -> MovedPhotograph:
    """Take two pictures of a signal that moves by a formula from the first to the second.

    Parameters
    ----------
    noise : float, optional
        Of each picture, grey levels; None: neither noise nor rounding.
    seed : int, optional
        Of the noise.
    """
    rows, columns = signal.picture_shape
    y, x = np.mgrid[:rows, :columns].astype(float)
    x, y = x - (columns - 1) / 2, y - (rows - 1) / 2
    first, second = signal.read(x, y), signal.read(*motion.origin(x, y, 1))
    u, v = motion.displacement(x, y, 0, 1)
    valid = (np.abs(x + u) <= x.max()) & (np.abs(y + v) <= y.max())
    if noise is not None:
        generator = np.random.default_rng(seed)
        first, second = (_exposed(picture, noise, generator) for picture in (first, second))
    displacement = np.stack([u, v], axis=-1).astype(np.float32)
    return MovedPhotograph(first.astype(np.float32), second.astype(np.float32), displacement, valid)


def read_photograph(path: Path) -> np.ndarray:
    """Grey levels (H, W) uint8 of a photograph.

    Raises
    ------
    ValueError
        No picture.
    """
    import cv2

    photograph = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    if photograph is None:
        raise ValueError(f"{path}: no picture that can be read")
    return photograph


def photograph_cases(path: Path | None) -> "list[CaseSource]":
    """A photograph moved by every motion of `MOTIONS`.

    Parameters
    ----------
    path : Path, optional
        A photograph of nothing but soil. Without it one of the test data in `$SOFTBED_DATA` is taken; without
        that there are no cases.

    Raises
    ------
    ValueError
        No photograph at the path.
    """
    soil: tuple[slice, slice] = np.s_[:, :]
    if path is None:
        name, soil = _TBAR
        path = Path(os.environ.get("SOFTBED_DATA", "nowhere")) / name
        if not path.is_file():
            return []
    if not path.is_file():
        raise ValueError(f"{path}: no such file: a photograph of soil is needed")
    return [partial(_case, path, soil, name) for name in MOTIONS]


def _case(path: Path, soil: tuple[slice, slice], name: str) -> "Case":
    from validation.bench.flow_case import Case

    photograph, motion = read_photograph(path)[soil], MOTIONS[name]
    rows, columns = photograph.shape
    moved = moved_photograph(Signal(photograph if columns >= rows else photograph.T), motion)
    regions = {"all": moved.valid}
    if isinstance(motion, ShearBand):
        y, x = np.mgrid[: moved.first.shape[0], : moved.first.shape[1]]
        radius = np.hypot(x - (x.max() / 2), y - (y.max() / 2))
        regions["band"] = moved.valid & (np.abs(radius - motion.radius) < _BAND_WITHIN)
        regions["inside the band"] = moved.valid & (radius < motion.radius - 2 * _BAND_WITHIN)
    return Case(f"{path.stem}, {name}", moved.first, moved.second, moved.displacement, regions)


def _low_passed(points: np.ndarray) -> np.ndarray:
    """Without what varies faster than `STOP`, mirrored at the border."""
    from scipy.fft import dctn, idctn

    down, across = (np.arange(count) / (2 * count) * FINER for count in points.shape)
    frequency = np.hypot(down[:, None], across)
    share = np.clip((STOP - frequency) / (STOP - PASS), 0, 1)
    return idctn(dctn(points, type=2) * (1 - np.cos(np.pi * share)) / 2, type=2)


def _exposed(picture: np.ndarray, noise: float, generator: np.random.Generator) -> np.ndarray:
    return np.rint(np.clip(picture + noise * generator.standard_normal(picture.shape), 0, 255))
