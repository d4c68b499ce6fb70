"""How much signal over noise averaging gains, from the measurements alone (section 3.3)."""

from dataclasses import dataclass

import numpy as np

from soft.doubling_blocks import DoublingBlocks

# A pixel counts in a block's mean if at least this share of the block's pairs measured it.
LEAST_SHARE = 0.75


@dataclass(frozen=True, eq=False)
class AveragingGain:
    """Signal-to-noise ratio of means over 1, 2, 4, ... pairs.

    The pairs are split into a first and a second half. Means over N pairs of the one are compared with means
    over N pairs of the other, half the sequence later: what differs is noise (errors, and transients of the
    soil), what both have is signal. Errors that are the same in both halves, as those of the optics, count as
    signal: only a truth tells them apart.

    Attributes
    ----------
    pair_count : (K,) int
        N: 1, 2, 4, ..., up to half of the pairs; empty for a single pair.
    block_count : (K,) int
        How many couples of means were compared: few are a rough estimate.
    signal : (K,) float
        Root mean square of the displacement without noise, px.
    noise : (K,) float
        Root mean square of the noise of a mean over N pairs, px, both components together.
    """

    pair_count: np.ndarray
    block_count: np.ndarray
    signal: np.ndarray
    noise: np.ndarray

    @property
    def signal_to_noise(self) -> np.ndarray:
        """(K,): signal over noise; NaN where there is more noise than signal to see."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.signal / self.noise

    @property
    def gain(self) -> np.ndarray:
        """(K,): noise of single pairs over that of means."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.noise[:1] / self.noise

    @property
    def ideal(self) -> np.ndarray:
        """(K,): the square root of N, for errors that are random and independent."""
        return np.sqrt(self.pair_count)

    @property
    def lost(self) -> np.ndarray:
        """(K,): share of the ideal gain that correlation between pairs takes away; below 0 if it helps.

        Neighbouring pairs share a picture: its noise comes into both with opposite signs, and helps.
        """
        return 1 - self.gain / self.ideal

    @property
    def remark(self) -> str:
        """The result in words."""
        if not len(self.pair_count):
            return "a single pair: nothing is averaged"
        if len(self.pair_count) == 1:
            return (
                f"signal over noise {self.signal_to_noise[0]:.1f} of single pairs; more pairs tell the gain"
            )
        return (
            f"signal over noise {self.signal_to_noise[0]:.1f} of single pairs, "
            f"{self.signal_to_noise[-1]:.1f} of means over {self.pair_count[-1]}: "
            f"gained {self.gain[-1]:.2f}, ideal {self.ideal[-1]:.2f}"
        )


@dataclass(frozen=True, eq=False)
class _Block:
    """Sums of vectors (2, H, W) and how often (H, W), of as many pairs of both halves."""

    sums: tuple[np.ndarray, np.ndarray]
    counts: tuple[np.ndarray, np.ndarray]

    def __add__(self, other: "_Block") -> "_Block":
        one, two = ((self.sums[k] + other.sums[k], self.counts[k] + other.counts[k]) for k in (0, 1))
        return _Block((one[0], two[0]), (one[1], two[1]))


class GainTally:
    """Collects couples of pairs, one of each half, in order of time; a few pictures for each doubling."""

    def __init__(self) -> None:
        self._blocks: DoublingBlocks[_Block] = DoublingBlocks()
        self._compared: list[list[tuple[float, float, float]]] = []

    def add(self, first: np.ndarray, second: np.ndarray) -> None:
        """Add vectors (2, H, W) of a pair of the first half and one of the second; NaN where not measured."""
        known = [np.isfinite(vectors).all(axis=0) for vectors in (first, second)]
        one, two = (np.where(k, v, 0).astype(np.float64) for k, v in zip(known, (first, second), strict=True))
        block = _Block((one, two), (known[0].astype(np.int32), known[1].astype(np.int32)))
        for level, completed in enumerate(self._blocks.add(block)):
            if level == len(self._compared):
                self._compared.append([])
            self._compared[level].append(_compared(completed, 2**level))

    def result(self) -> AveragingGain:
        """Pool what was compared, every pixel counting alike."""
        rows = []
        for level, parts in enumerate(self._compared):
            pixels, signal, noise = np.sum(parts, axis=0)
            if pixels:
                rows.append((2**level, len(parts), signal / pixels, noise / pixels))
        table = np.array(rows, np.float64).reshape(len(rows), 4)
        with np.errstate(invalid="ignore"):
            signal, noise = np.sqrt(table[:, 2]), np.sqrt(table[:, 3])
        return AveragingGain(table[:, 0].astype(int), table[:, 1].astype(int), signal, noise)


def _compared(block: _Block, length: int) -> tuple[float, float, float]:
    """Pixels, and over them the sums of signal and noise power, px^2, of means over `length` pairs."""
    counts = block.counts
    told = (counts[0] >= LEAST_SHARE * length) & (counts[1] >= LEAST_SHARE * length)
    first, second = (block.sums[k][:, told] / counts[k][told] for k in (0, 1))
    # Were errors independent, this is the variance of a single pair, whatever pairs are missing.
    spread = np.square(first - second).sum(axis=0) / (1 / counts[0][told] + 1 / counts[1][told])
    return float(told.sum()), float((first * second).sum()), float(spread.sum() / length)
