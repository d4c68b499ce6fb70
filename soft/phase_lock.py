"""Phase-locked averaging: mean soil flow at every stage of a grouser's passage.

A plain mean over a periodic event, as the passing of grousers, blurs it (section 3.3). Pairs at the same
stage are averaged with each other instead.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from soft.averaging import MeanFlow, average_flow

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, eq=False)
class PhaseLockedFlow:
    """Mean flow in bins of the phase.

    Attributes
    ----------
    phase : (B,) float64
        Middle of each bin, in periods: 0 to 1.
    means : tuple of MeanFlow or None
        The mean in each bin; None where no pair falls.
    pair_count : (B,) int
        Pairs in each bin.
    """

    phase: np.ndarray
    means: tuple[MeanFlow | None, ...]
    pair_count: np.ndarray

    @property
    def remark(self) -> str:
        """Say how the bins are filled."""
        told = f"{self.pair_count.sum()} pairs in {len(self.phase)} bins of phase"
        empty = int((self.pair_count == 0).sum())
        if empty:
            return f"{told}, {empty} of them empty: pairs come back to the same phases; take fewer bins"
        return f"{told}, {self.pair_count.min()} to {self.pair_count.max()} in each"


def grouser_phase(wheel_angle: np.ndarray, *, grouser_count: int) -> np.ndarray:
    """Stage of the grousers' passage, in periods 0 to 1, from how far the wheel has turned.

    Parameters
    ----------
    wheel_angle : array
        In radians, growing as the wheel turns; at 0 a grouser stands where phase 0 is meant to be. A pair's
        motion belongs to the middle between its pictures: give the mean of the two angles.
    grouser_count : int
        Equal grousers around the wheel.

    Raises
    ------
    ValueError
        If there is no grouser.
    """
    if grouser_count < 1:
        raise ValueError(f"grouser_count: {grouser_count!r}: must be at least 1")
    return np.mod(np.asarray(wheel_angle, np.float64) * grouser_count / (2 * np.pi), 1.0)


def wheel_angle_of(flow: "xarray.Dataset", *, angular_speed: float, start: float = 0.0) -> np.ndarray:
    """Angle in radians that a steadily turning wheel has at the middle of each pair.

    Parameters
    ----------
    flow : xarray.Dataset
        A SoilFlow with a frame rate.
    angular_speed : float
        In rad/s; its sign does not matter as long as `start` has the same.
    start : float, optional
        Angle at time 0, in radians.

    Raises
    ------
    ValueError
        If the frame rate is unknown, so that there is no time in seconds.
    """
    if "frame_rate" not in flow.attrs:
        raise ValueError("frame_rate: unknown: the wheel's angle cannot be told from time")
    middle = (flow["first_frame"].to_numpy() + flow["second_frame"].to_numpy()) / 2 / flow.attrs["frame_rate"]
    return start + angular_speed * middle


def phase_locked_average(
    flow: "xarray.Dataset",
    phase: np.ndarray,
    *,
    bin_count: int = 8,
    pairs: Sequence[int] | None = None,
    positions: np.ndarray | None = None,
) -> PhaseLockedFlow:
    """Average soil flow over the pairs at each stage of a periodic event.

    Within a bin the event is still blurred, by the bin's width: a component that varies as a sine with the
    phase comes out smaller by sinc(1 / `bin_count`), 2.6 % for eight bins. Bins are centred: the first
    reaches from half a width before phase 0 to half a width after.

    Parameters
    ----------
    flow : xarray.Dataset
        A SoilFlow.
    phase : (P,) array
        Phase of each of the pairs averaged, in periods, as of `grouser_phase`; whole periods do not matter.
    bin_count : int, optional
        Bins that a period is divided into.
    pairs, positions
        As in `average_flow`.

    Raises
    ------
    ValueError
        If `phase` has another length or is not finite, or there is no bin.
    """
    chosen = np.arange(flow.sizes["pair"]) if pairs is None else np.asarray(pairs, np.intp)
    phase = np.asarray(phase, np.float64)
    if phase.shape != chosen.shape or not np.isfinite(phase).all():
        raise ValueError(f"phase: shape {phase.shape}: must be ({len(chosen)},), finite: one for each pair")
    if bin_count < 1:
        raise ValueError(f"bin_count: {bin_count!r}: must be at least 1")
    number = np.rint(phase * bin_count).astype(np.intp) % bin_count
    members = [np.flatnonzero(number == k) for k in range(bin_count)]
    places = None if positions is None else np.asarray(positions, np.float64)
    means = tuple(_mean(flow, chosen, places, m) if len(m) else None for m in members)
    return PhaseLockedFlow(np.arange(bin_count) / bin_count, means, np.array([len(m) for m in members]))


def _mean(
    flow: "xarray.Dataset", pairs: np.ndarray, positions: np.ndarray | None, members: np.ndarray
) -> MeanFlow:
    if positions is None:
        return average_flow(flow, pairs=pairs[members])
    x, y = positions[0]
    return average_flow(flow, pairs=pairs[members], positions=positions[members], reference=(x, y))
