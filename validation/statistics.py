"""How sure a number is: intervals by block bootstrap, and differences between methods.

What is independent are realisations (another bed, another texture, other noise), and stretches of frames that
lie further apart than soil remembers; never pixels. So realisations are drawn with replacement, and within
each one blocks of consecutive frames, wrapped around (Politis and Romano 1992, "A circular block-resampling
procedure for stationary data"). As there are few realisations, deviations are widened from the normal law to
Student's t (Hesterberg 2015, "What teachers should know about the bootstrap"). Methods are compared on the
same pictures: what is resampled is their difference.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

LEVEL = 0.95
NORMAL_95 = 1.96
"""Standard deviations from the mean of a normal distribution, each way, that hold 95 % of it."""
RESAMPLES = 4000

Realisations = Sequence[np.ndarray]
"""One number a picture pair, in order of time, for each realisation: (N_r,) float each."""


class StatisticsError(ValueError):
    """Numbers that no interval can be had of; the message is one line."""


@dataclass(frozen=True)
class Interval:
    """A mean and how sure it is.

    Attributes
    ----------
    value : float
        Mean over realisations of the mean over their picture pairs.
    low, high : float
        Ends of the interval; NaN where one realisation of one block leaves nothing to draw from.
    realisation_count : int
        Realisations it rests on.
    pair_count : int
        Picture pairs it rests on.
    """

    value: float
    low: float
    high: float
    realisation_count: int
    pair_count: int

    def told(self, form: str) -> str:
        """The value and half of the interval, in a format."""
        value = format(self.value, form)
        if np.isnan(self.low):
            return value
        return f"{value} \N{PLUS-MINUS SIGN} {format((self.high - self.low) / 2, form)}"


def block_bootstrap(realisations: Realisations, *, block_length: int, seed: int = 0) -> Interval:
    """Mean of numbers that are correlated in time, with its percentile interval.

    Parameters
    ----------
    realisations : sequence of (N_r,) arrays
        NaN where a pair has no such number (no pixel in the stratum); such pairs are left out.
    block_length : int
        Picture pairs a block: more than the soil remembers.
    seed : int
        Of the resampling.

    Raises
    ------
    StatisticsError
        There is no number, or the block length is none.
    """
    return _bootstrap(realisations, block_length, seed)[0]


def _bootstrap(realisations: Realisations, block_length: int, seed: int) -> tuple[Interval, float]:
    """Interval of the mean, and the probability of one as far from zero if its expectation were zero."""
    kept = _known(realisations)
    if block_length < 1:
        raise StatisticsError(f"block_length: {block_length}: 1 at least")
    if not kept:
        raise StatisticsError("no picture pair has such a number")
    value = _centre(kept)
    counts = len(kept), sum(len(one) for one in kept)
    if _is_one_block(kept, block_length):
        return Interval(value, np.nan, np.nan, *counts), 1.0
    means = _resampled_means(kept, block_length, np.random.default_rng(seed))
    low, high = np.quantile(means, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return Interval(value, float(low), float(high), *counts), _probability(means - value, value)


def _probability(deviations: np.ndarray, value: float) -> float:
    """Two-sided: how often a mean whose expectation is shifted to zero is as far from it as the one found."""
    if value == 0:
        return 1.0
    return float((np.count_nonzero(np.abs(deviations) >= abs(value)) + 1) / (len(deviations) + 1))


def paired_difference(
    first: Realisations, second: Realisations, *, block_length: int, seed: int = 0
) -> tuple[Interval, float]:
    """How two methods differ on the same realisations and picture pairs.

    Parameters
    ----------
    first, second : sequence of (N_r,) arrays
        Errors of each, as `block_bootstrap` takes them, of the same shapes.
    block_length, seed
        As of `block_bootstrap`.

    Returns
    -------
    Interval
        Of first less second: negative where the first has the smaller error.
    float
        Two-sided probability of so large a difference if there were none. See `holm` for several of them.

    Raises
    ------
    StatisticsError
        They were not measured on the same pictures.
    """
    if [np.shape(one) for one in first] != [np.shape(one) for one in second]:
        raise StatisticsError("the two were not measured on the same pictures")
    differences = [np.subtract(a, b) for a, b in zip(first, second, strict=True)]
    return _bootstrap(differences, block_length, seed)


def stratified_bootstrap(
    scenes: Sequence[Realisations], *, block_length: int, seed: int = 0
) -> tuple[Interval, float]:
    """Mean over scenes, each counted alike, with its interval: scenes are given, realisations are drawn.

    Within every scene, realisations and blocks of their frames are drawn as `block_bootstrap` does. What few
    realisations lack is made up for once, by Student's t with the degrees of freedom of the mean's variance
    (Satterthwaite 1946), since many scenes of two realisations know more of it than one such scene.

    Parameters
    ----------
    scenes : sequence of sequences of (N_r,) arrays
        For each scene, what `block_bootstrap` takes. A scene of one realisation is taken to vary as the
        others do.

    Returns
    -------
    Interval
    float
        Two-sided probability of so large a mean if its expectation were zero; 1 where nothing is known.

    Raises
    ------
    StatisticsError
        There is no number.
    """
    kept = [known for known in map(_known, scenes) if known]
    if not kept:
        raise StatisticsError("no picture pair has such a number")
    value = float(np.mean([_centre(one) for one in kept]))
    deviations = _stratified_deviations(kept, block_length, np.random.default_rng(seed))
    counts = len([r for one in kept for r in one]), sum(len(r) for one in kept for r in one)
    if deviations is None:
        return Interval(value, np.nan, np.nan, *counts), 1.0
    low, high = value + np.quantile(deviations, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return Interval(value, float(low), float(high), *counts), _probability(deviations, value)


def _stratified_deviations(
    scenes: list[list[np.ndarray]], block_length: int, generator: np.random.Generator
) -> np.ndarray | None:
    """Deviations of resampled means over scenes: (RESAMPLES,); None if no scene has two realisations."""
    several = [one for one in scenes if len(one) > 1]
    if not several:
        return None
    drawn = [
        (_drawn_means(one, block_length, generator) - _centre(one)) * np.sqrt(len(one) / (len(one) - 1))
        for one in several
    ]
    variances = np.array([one.var() for one in drawn])
    degrees = np.array([len(one) - 1 for one in several])
    total = variances.sum()
    freedom = total**2 / np.sum(variances**2 / degrees) if total > 0 else degrees.sum()
    # Scenes of one realisation add as much to the variance as the others do on average.
    unknown = np.sqrt(len(scenes) / len(several))
    return np.sum(drawn, axis=0) / len(scenes) * unknown * _t_over_normal(freedom)


def holm(probabilities: Sequence[float]) -> list[float]:
    """Correct probabilities for being several, so that the chance of any false one is kept (Holm 1979).

    >>> holm([0.01, 0.04, 0.03])
    [0.03, 0.06, 0.06]
    """
    order = np.argsort(probabilities)
    corrected = np.empty(len(order))
    highest = 0.0
    for rank, index in enumerate(order):
        highest = max(highest, min(1.0, (len(order) - rank) * probabilities[index]))
        corrected[index] = highest
    return [float(p) for p in corrected]


def _is_one_block(realisations: list[np.ndarray], block_length: int) -> bool:
    """Whether nothing is known of how much the numbers vary from block to block."""
    return len(realisations) == 1 and len(realisations[0]) <= block_length


def _known(realisations: Realisations) -> list[np.ndarray]:
    arrays = (np.asarray(one, np.float64) for one in realisations)
    return [one[np.isfinite(one)] for one in arrays if np.isfinite(one).any()]


def _resampled_means(
    realisations: list[np.ndarray], block_length: int, generator: np.random.Generator
) -> np.ndarray:
    """Mean of each resample, deviations widened for there being few realisations: (RESAMPLES,)."""
    centre = _centre(realisations)
    deviations = _drawn_means(realisations, block_length, generator) - centre
    return np.asarray(centre + deviations * _widening(len(realisations)))


def _drawn_means(
    realisations: list[np.ndarray], block_length: int, generator: np.random.Generator
) -> np.ndarray:
    """Mean of each resample: (RESAMPLES,)."""
    count = len(realisations)
    # What the mean of a realisation would be, had its blocks come otherwise: (realisation, resample).
    within = np.stack([_block_means(one, block_length, generator) for one in realisations])
    drawn = generator.integers(0, count, (RESAMPLES, count))
    return np.asarray(within[drawn, np.arange(RESAMPLES)[:, np.newaxis]].mean(axis=1))


def _centre(realisations: list[np.ndarray]) -> float:
    return float(np.mean([one.mean() for one in realisations]))


def _widening(count: int) -> float:
    """What a bootstrap over few realisations lacks: n - 1 for n, and Student's t for the normal law."""
    if count < 2:
        return 1.0
    return float(np.sqrt(count / (count - 1)) * _t_over_normal(count - 1))


def _t_over_normal(degrees: float) -> float:
    """How much wider Student's t of so many degrees of freedom is than the normal law."""
    from scipy.stats import norm, t

    tail = (1 + LEVEL) / 2
    return float(t.ppf(tail, degrees) / norm.ppf(tail))


def _block_means(values: np.ndarray, block_length: int, generator: np.random.Generator) -> np.ndarray:
    """Means of resamples of one realisation by circular blocks: (RESAMPLES,)."""
    count = len(values)
    length = min(block_length, count)
    block_count = -(-count // length)
    circle = np.concatenate([values, values[: length - 1]])
    sums = np.convolve(circle, np.ones(length), mode="valid")  # one block from each start
    starts = generator.integers(0, count, (RESAMPLES, block_count))
    return np.asarray(sums[starts].mean(axis=1) / length)
