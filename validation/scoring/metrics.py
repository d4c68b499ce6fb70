"""How wrong a measured displacement is, over any set of pixels."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

WRONG_ABOVE = (0.3, 0.56, 1.0)
"""End-point errors in px above which a pixel counts as wrong.

0.3 is the 95 % error of the published rotation test, 0.56 the published bound of agreement with feature
tracking (Skonieczny et al. 2014, sections 3.1.1 and 3.2), 1.0 a whole pixel.
"""


@dataclass(frozen=True)
class ErrorSummary:
    """Errors over the pixels of one stratum.

    Attributes
    ----------
    pixel_count : int
        Pixels of the stratum, measured or not.
    coverage : float or None
        Share of them that was measured; None in an empty stratum.
    median, mean, p95, rmse : float or None
        Of the end-point error over the measured pixels, px; None where nothing was measured.
    bias_u, bias_v : float or None
        Mean of measured less true displacement over the measured pixels, px.
    wrong_share : dict
        For each bound of `WRONG_ABOVE`, the share of all pixels whose error is above it or not measured; of
        a method that tells of the nodes of a grid only, of all pixels that hold a node.
    node_count : int or None
        Pixels of the stratum that hold a node, measured or not; None for methods that tell of every pixel.
    """

    pixel_count: int
    coverage: float | None
    median: float | None
    mean: float | None
    p95: float | None
    rmse: float | None
    bias_u: float | None
    bias_v: float | None
    wrong_share: dict[str, float | None]
    node_count: int | None = None

    def to_dict(self) -> dict[str, Any]:
        """As it stands in scores.json."""
        told = asdict(self)
        if self.node_count is None:
            del told["node_count"]
        return told


def end_point_error(difference_u: np.ndarray, difference_v: np.ndarray) -> np.ndarray:
    """Euclidean norm of measured less true displacement, px (Skonieczny et al. 2014, Eq. 6); float64."""
    return np.hypot(difference_u, difference_v, dtype=np.float64)


class ErrorTally:
    """Collects the differences of one set of pixels, picture pair by picture pair.

    Every error is kept as float32, so that percentiles are exact: 4 bytes a measured pixel. Means are summed
    in float64.
    """

    def __init__(self) -> None:
        self._pixel_count = 0
        self._node_count: int | None = None
        self._errors: list[np.ndarray] = []
        self._sums = np.zeros(4)

    def add(
        self, difference_u: np.ndarray, difference_v: np.ndarray, *, node_count: int | None = None
    ) -> None:
        """Add pixels: measured less true displacement, px, (N,) each; NaN where not measured.

        `node_count` says how many of them hold a node of a grid; None: the method tells of all.
        """
        measured = np.isfinite(difference_u) & np.isfinite(difference_v)
        u = difference_u[measured].astype(np.float64)
        v = difference_v[measured].astype(np.float64)
        error = end_point_error(u, v)
        self._pixel_count += measured.size
        if node_count is not None:
            self._node_count = node_count + (self._node_count or 0)
        self._sums += [error.sum(), np.square(error).sum(), u.sum(), v.sum()]
        self._errors.append(error.astype(np.float32))

    @staticmethod
    def summary(tallies: "Sequence[ErrorTally]") -> ErrorSummary:
        """Errors over the union of disjoint sets of pixels."""
        pixel_count = sum(tally._pixel_count for tally in tallies)
        errors = [part for tally in tallies for part in tally._errors]
        error = np.concatenate(errors) if errors else np.empty(0, np.float32)
        sums = sum((tally._sums for tally in tallies), np.zeros(4))
        nodes = [tally._node_count for tally in tallies if tally._node_count is not None]
        return _summary(pixel_count, sum(nodes) if nodes else None, error, sums)


def _summary(pixel_count: int, node_count: int | None, error: np.ndarray, sums: np.ndarray) -> ErrorSummary:
    median = mean = p95 = rmse = bias_u = bias_v = None
    if error.size:
        # The result overwrites the input's order, not its values: no second copy of what may be large.
        median, p95 = (float(q) for q in np.percentile(error, [50, 95], overwrite_input=True))
        mean, mean_square, bias_u, bias_v = (float(s) for s in sums / error.size)
        rmse = mean_square**0.5
    return ErrorSummary(
        pixel_count=pixel_count,
        coverage=error.size / pixel_count if pixel_count else None,
        median=median,
        mean=mean,
        p95=p95,
        rmse=rmse,
        bias_u=bias_u,
        bias_v=bias_v,
        wrong_share=_wrong_share(pixel_count if node_count is None else node_count, error),
        node_count=node_count,
    )


def _wrong_share(count: int, error: np.ndarray) -> dict[str, float | None]:
    if not count:
        return {str(bound): None for bound in WRONG_ABOVE}
    right = {bound: int(np.count_nonzero(error <= np.float32(bound))) for bound in WRONG_ABOVE}
    return {str(bound): 1 - rightly / count for bound, rightly in right.items()}
