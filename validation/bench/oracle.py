"""The floor of affine windows: what one finds that is told which pixels truly move alike.

At each pixel an affine motion is fitted to the pictures in a disc, from those pixels alone whose true motion
agrees with the affine continuation of the pixel's own, next to it or not: whatever there is to be known about
breaks of the motion, this oracle knows. Of several discs, and of several bounds on what agrees, it takes the
one whose error is *expected* to be least: by how much the noise-free fit to the true motion is off, and how
much the residuals that remain at the true motion scatter the fit. It does not see the actual error, which
would be a floor that nobody could have.

The fit starts at the true motion and ends where the pictures draw it. Its weights are Lorentzian, as the
robust estimator's, in two versions: of the residuals at the true motion (the oracle knows as well whose light
is not the soil's own: another surface's, or of what is hidden in the second picture), or of the residuals as
they come.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np

if TYPE_CHECKING:
    from soft.flow.robust_affine.brightness import Constraints, PicturePair

RADII = (2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0)
"""Of the discs, px."""
TOLERANCES = (0.05, 0.15, 0.5)
"""How far a pixel's true motion may be from the continuation of another's to count as the same, px."""
_WIDTH = 2.0
"""Of the Lorentzian, standard deviations of the residuals; the robust estimator's."""
_TURNS = 6
"""Of Gauss-Newton; after four, nothing changes where weights are the truth's."""


@dataclass(frozen=True, eq=False)
class Windows:
    """What the oracle fits in, at some pixels.

    Attributes
    ----------
    places : (P, 2) int32 array
        Rows and columns.
    members : (P, 6) float32 array
        Affine motions; true motions that agree with one are its window's.
    chosen : (P, 3) float32 array
        Expected squared end-point error (px^2; infinite where too little moves alike to fit to), radius and
        tolerance (px).
    """

    places: np.ndarray
    members: np.ndarray
    chosen: np.ndarray

    @property
    def expected(self) -> np.ndarray:
        """Root of the expected squared end-point error, px: (P,)."""
        return np.sqrt(self.chosen[:, 0])


@dataclass(frozen=True, eq=False)
class Oracle:
    """Two pictures, and everything about their motion. Taichi must have been started.

    Attributes
    ----------
    pair : PicturePair
    constraints : Constraints
        The pixels' equations at the true motion.
    motion : (H, W, 2) float32 array
        The true one, px; 0 where it is not known.
    """

    pair: "PicturePair"
    constraints: "Constraints"
    motion: np.ndarray

    @classmethod
    def of(cls, first: np.ndarray, second: np.ndarray, truth: np.ndarray, known: np.ndarray) -> Self:
        """From pictures, their true displacement and the pixels that may be used.

        Parameters
        ----------
        first, second : (H, W) float32 array
            Grey, 0-255.
        truth : (H, W, 2) array
            px.
        known : (H, W) bool array
            Soil whose true motion is known.
        """
        from soft.flow.robust_affine.brightness import PicturePair

        motion = np.where(known[:, :, None], truth, 0).astype(np.float32)
        models = np.zeros((*known.shape, 6), np.float32)
        models[:, :, ::3] = motion
        pair = PicturePair.of(first, second, known)
        return cls(pair, pair.constrain(models), motion)

    def windows(
        self,
        places: np.ndarray,
        *,
        radii: Sequence[float] = RADII,
        tolerances: Sequence[float] = TOLERANCES,
    ) -> Windows:
        """The best window at each of some known pixels, (P, 2) int32 rows and columns."""
        from validation.bench import oracle_kernels as kernels

        members, chosen = np.zeros((len(places), 6), np.float32), np.zeros((len(places), 3), np.float32)
        kernels.choose_windows(
            places, self.constraints.values, self.motion, self.pair.usable, np.array(radii, np.float32),
            np.array(tolerances, np.float32), self.constraints.noise(), _WIDTH, members, chosen,
        )  # fmt: skip
        return Windows(places, members, chosen)

    def measure(
        self, windows: Windows, *, reweigh: bool = False, start: np.ndarray | None = None
    ) -> np.ndarray:
        """Fit in the windows.

        Parameters
        ----------
        windows : Windows
        reweigh : bool, optional
            Weigh by the residuals as they come, not by those at the true motion.
        start : (P, 2) array, optional
            Displacement to start from, px; by default the true one.

        Returns
        -------
        (P, 2) float32 array
            Displacement, px; NaN where there is no window.
        """
        from validation.bench import oracle_kernels as kernels

        models = windows.members.copy()
        if start is not None:
            models[:, ::3] = start
        kernels.measure(
            windows.places, self.constraints.values, self.pair.first, self.pair.coefficients,
            self.constraints.gain, self.motion, self.pair.usable, windows.members, windows.chosen,
            self.constraints.noise(), _WIDTH, _TURNS, int(reweigh), models,
        )  # fmt: skip
        return np.where(np.isfinite(windows.chosen[:, :1]), models[:, ::3], np.nan)
