"""Signal averaging: mean vectors over picture pairs (section 3.3)."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from soft.averaging_gain import AveragingGain, GainTally
from soft.pair_motion import motion_between_nodes
from soft.segmentation import LEAST_SPEED_STEP, MovingRegion, moving_mask

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, eq=False)
class MeanFlow:
    """Soil flow averaged over picture pairs: means of vectors, never of magnitudes.

    Attributes
    ----------
    u, v : (H, W) float32
        Mean inertial displacement in px a pair, x right and y down; NaN where it was never measured.
    count : (H, W) int32
        Pairs that each mean is of: those in which the pixel was soil and measured.
    standard_error_u, standard_error_v : (H, W) float32
        Standard deviation among the pairs over the square root of `count`, px; NaN below two pairs. True as
        far as pairs err independently: `gain` tells how far.
    soil : (H, W) bool
        Soil in at least half of the pairs.
    pairs : tuple of int
        Which pairs of the SoilFlow.
    gain : AveragingGain
        What averaging did for the signal-to-noise ratio.
    metres_per_pixel, frame_rate : float or None
        As in the SoilFlow.
    spacing : float
        Px between the nodes of a grid that vectors are linear between; 0 where each is measured itself.
    """

    u: np.ndarray
    v: np.ndarray
    count: np.ndarray
    standard_error_u: np.ndarray
    standard_error_v: np.ndarray
    soil: np.ndarray
    pairs: tuple[int, ...]
    gain: AveragingGain
    metres_per_pixel: float | None = None
    frame_rate: float | None = None
    spacing: float = 0.0

    @property
    def displacement(self) -> np.ndarray:
        """(H, W, 2) float32, (u, v) in px."""
        return np.stack([self.u, self.v], axis=-1)

    @property
    def speed(self) -> np.ndarray:
        """Magnitude of the mean vector, (H, W) px a pair."""
        return np.hypot(self.u, self.v)

    def moving_region(self, *, seed: int = 0) -> MovingRegion:
        """Tell moving from resting soil by the mean vectors, as `moving_mask` does by those of a pair.

        Errors of a mean are smaller than those of a pair by what averaging gained over half of the pairs, at
        least; so much less need the classes lie apart. This is how motion shows that no pair shows (Fig. 13).
        """
        gained = max(1.0, float(self.gain.gain[-1])) if len(self.gain.pair_count) else 1.0
        least = LEAST_SPEED_STEP / gained
        return moving_mask(self.speed, self.soil, seed=seed, least_step=least, reach=self.spacing)


def average_flow(
    flow: "xarray.Dataset",
    *,
    pairs: Sequence[int] | None = None,
    positions: np.ndarray | None = None,
    reference: tuple[float, float] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> MeanFlow:
    """Average the inertial displacement over picture pairs, in the implement's frame.

    Each pixel's mean is over the pairs in which it was soil and measured. A camera that travels with the
    implement sees it in one place: then nothing is shifted. Else `positions` says where the implement is. Two
    pairs at a time are read; memory holds a few pictures, however many pairs there are. A grid's motion is
    taken as linear between its nodes, which may lie elsewhere in each pair.

    Parameters
    ----------
    flow : xarray.Dataset
        A SoilFlow.
    pairs : sequence of int, optional
        Which pairs, in order of time; all by default. Negative ones count from the end.
    positions : (P, 2) array, optional
        x, y in px of the implement in the first picture of each of these pairs. Fields are shifted by whole
        px so that it comes to lie at `reference`; vectors are not changed.
    reference : (float, float), optional
        x, y in px; where the implement is in the first of these pairs by default.
    progress : callable, optional
        Called with (pairs done, pairs in all).

    Raises
    ------
    IndexError
        If there is no such pair.
    ValueError
        If there is no pair at all, or `positions` has another length.
    """
    chosen = _chosen(flow, pairs)
    shifts = _shifts(positions, reference, len(chosen))
    sums, gain = _Sums.empty((flow.sizes["y"], flow.sizes["x"])), GainTally()
    half = len(chosen) // 2
    done = 0
    for group in _halves(len(chosen)):
        vectors = [_pair_vectors(flow, chosen[k], shifts[k], sums) for k in group]
        if len(group) == 2 and half:
            gain.add(*vectors)
        done += len(group)
        if progress:
            progress(done, len(chosen))
    return sums.mean_flow(flow, chosen, gain.result())


def _halves(count: int) -> Iterator[tuple[int, ...]]:
    """Indices of the first half, each with its counterpart in the second; the odd one out comes last."""
    half = count // 2
    for k in range(half):
        yield k, half + k
    if count % 2:
        yield (count - 1,)


def _chosen(flow: "xarray.Dataset", pairs: Sequence[int] | None) -> tuple[int, ...]:
    every = range(flow.sizes["pair"])
    chosen = tuple(every if pairs is None else (every[k] for k in pairs))
    if not chosen:
        raise ValueError("pairs: none: at least one is needed for a mean")
    return chosen


def _shifts(
    positions: np.ndarray | None, reference: tuple[float, float] | None, count: int
) -> list[tuple[int, int]]:
    """Whole px to shift each field right and down."""
    if positions is None:
        return [(0, 0)] * count
    places = np.asarray(positions, np.float64)
    if places.shape != (count, 2) or not np.isfinite(places).all():
        raise ValueError(f"positions: shape {places.shape}: must be ({count}, 2), finite: x, y for each pair")
    target = places[0] if reference is None else np.asarray(reference, np.float64)
    return [(int(dx), int(dy)) for dx, dy in np.rint(target - places)]


def _pair_vectors(flow: "xarray.Dataset", pair: int, shift: tuple[int, int], sums: "_Sums") -> np.ndarray:
    """Read a pair's vectors (2, H, W), NaN where not measured on soil, and add them to the sums."""
    motion = motion_between_nodes(flow, pair)
    sums.spacing = max(sums.spacing, motion.spacing)
    components = np.moveaxis(motion.displacement, 2, 0)
    vectors = np.stack([_shifted(component, shift, np.float32(np.nan)) for component in components])
    sums.add(vectors, _shifted(motion.soil, shift, False))
    return vectors


def _shifted(field: np.ndarray, shift: tuple[int, int], fill: object) -> np.ndarray:
    """Move a field (H, W) right and down by whole px; what comes into view is `fill`."""
    dx, dy = shift
    if not dx and not dy:
        return field
    height, width = field.shape
    moved = np.full(field.shape, fill, field.dtype)
    if abs(dx) < width and abs(dy) < height:
        to = (slice(max(dy, 0), height + min(dy, 0)), slice(max(dx, 0), width + min(dx, 0)))
        source = (slice(max(-dy, 0), height + min(-dy, 0)), slice(max(-dx, 0), width + min(-dx, 0)))
        moved[to] = field[source]
    return moved


@dataclass
class _Sums:
    """Sums over pairs: of vectors, of their components' squares, of how often."""

    total: np.ndarray
    squares: np.ndarray
    count: np.ndarray
    soil_count: np.ndarray
    spacing: float = 0.0

    @classmethod
    def empty(cls, shape: tuple[int, int]) -> "_Sums":
        return cls(
            np.zeros((2, *shape)), np.zeros((2, *shape)), np.zeros(shape, np.int32), np.zeros(shape, np.int32)
        )

    def add(self, vectors: np.ndarray, soil: np.ndarray) -> None:
        known = np.isfinite(vectors).all(axis=0)
        values = np.where(known, vectors, 0.0).astype(np.float64)
        self.total += values
        self.squares += np.square(values)
        self.count += known
        self.soil_count += soil

    def mean_flow(self, flow: "xarray.Dataset", pairs: tuple[int, ...], gain: AveragingGain) -> MeanFlow:
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = self.total / self.count
            # Rounding may leave a little less than nothing where all pairs agree.
            scatter = np.maximum(self.squares - self.count * np.square(mean), 0.0) / (self.count - 1)
            error = np.sqrt(scatter / self.count)
        mean[:, self.count < 1] = np.nan
        error[:, self.count < 2] = np.nan
        return MeanFlow(
            u=mean[0].astype(np.float32),
            v=mean[1].astype(np.float32),
            count=self.count,
            standard_error_u=error[0].astype(np.float32),
            standard_error_v=error[1].astype(np.float32),
            soil=2 * self.soil_count >= len(pairs),
            pairs=pairs,
            gain=gain,
            metres_per_pixel=flow.attrs.get("metres_per_pixel"),
            frame_rate=flow.attrs.get("frame_rate"),
            spacing=self.spacing,
        )
