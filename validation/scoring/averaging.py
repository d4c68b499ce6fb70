"""How much of a measurement's error averaging over pairs takes away, against the truth (section 3.3).

The data alone tell noise from signal by what repeats; errors that repeat, too, then pass for signal. Here the
mean over N pairs is compared with the mean of the truth over the same pairs.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from soft.doubling_blocks import DoublingBlocks

if TYPE_CHECKING:
    import xarray as xr

    from validation.scoring.truth_pass import TruePair

_NEEDED = ("inertial_u", "inertial_v", "valid", "soil")


@dataclass(frozen=True)
class AveragingScore:
    """Error of means over 1, 2, 4, ... pairs.

    Attributes
    ----------
    pair_count : tuple of int
        N.
    error : tuple of float
        Root mean square, over soil, of the distance between the mean measured inertial displacement and the
        mean true one, px.
    """

    pair_count: tuple[int, ...]
    error: tuple[float, ...]

    @property
    def gain(self) -> tuple[float, ...]:
        """Error of single pairs over that of means: the square root of N if errors are independent."""
        return tuple(self.error[0] / one if one else float("inf") for one in self.error)

    def to_dict(self) -> dict[str, Any]:
        """As it stands in scores.json, beside the method's other numbers."""
        return {"averaging": {"pair_count": list(self.pair_count), "error": list(self.error)}}

    @property
    def sentence(self) -> str:
        """The result in words."""
        if len(self.pair_count) < 2:
            return ""
        count = self.pair_count[-1]
        more = self.gain[-1] > count**0.5
        return (
            f"averaging {count} pairs takes the error (root mean square) from {self.error[0]:.3f} to "
            f"{self.error[-1]:.3f} px, a gain of {self.gain[-1]:.2f} where independent errors would give "
            f"{count**0.5:.2f}"
            + (" (neighbouring pairs share a picture and err in opposite directions)" if more else "")
        )


class AveragingTally:
    """Sums of one method's errors in blocks of 1, 2, 4, ... pairs."""

    def __init__(self) -> None:
        self._blocks: DoublingBlocks[np.ndarray] = DoublingBlocks()
        self._squares: list[np.ndarray] = []

    @staticmethod
    def suits(flow: "xr.Dataset") -> bool:
        """Whether a method tells inertial motion, at the same pixels in all pairs: a grid's nodes move."""
        return set(_NEEDED) <= set(flow.data_vars) and "node_x" not in flow

    def add(self, pair: "TruePair", flow: "xr.Dataset") -> None:
        """Add one pair of a SoilFlow, over `y, x`; what is not measured or not known counts in no mean."""
        error = _measured_motion(flow) - pair.motion
        known = np.isfinite(error).all(axis=0)
        # Both components' sums, and of how many pairs: (3, H, W).
        block = np.concatenate([np.where(known, error, 0.0), known[np.newaxis]], dtype=np.float64)
        for level, completed in enumerate(self._blocks.add(block)):
            if level == len(self._squares):
                self._squares.append(np.zeros(2))
            self._squares[level] += _mean_square(completed[:2], completed[2], 2**level)

    def result(self) -> AveragingScore | None:
        """Over all pairs added; None if nothing was measured."""
        told = [(2**k, (total / count) ** 0.5) for k, (total, count) in enumerate(self._squares) if count]
        if not told:
            return None
        counts, errors = zip(*told, strict=True)
        return AveragingScore(tuple(counts), tuple(float(one) for one in errors))


def _mean_square(total: np.ndarray, count: np.ndarray, length: int) -> np.ndarray:
    """Sum over pixels of the squared mean error, and how many: of those known in every pair of the block."""
    whole = count == length
    return np.array([np.square(total[:, whole] / length).sum(), whole.sum()])


def _measured_motion(flow: "xr.Dataset") -> np.ndarray:
    """Inertial displacement (2, H, W) of measured soil, NaN elsewhere."""
    known = flow["valid"].values.astype(bool) & flow["soil"].values.astype(bool)
    return np.where(known, np.stack([flow["inertial_u"].values, flow["inertial_v"].values]), np.nan)
