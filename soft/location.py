"""Location in the sense of statistics: median and mode of a field of numbers, with 95 % intervals.

Errors of neighbouring pixels go together, so a million of them know far less than a million numbers would.
How much less is taken from the field itself: it is cut into square blocks. What their sums scatter by tells
what the sum over all scatters by, as soon as blocks are larger than the errors' reach. Blocks are made larger
and larger, and the largest scatter counts (blocking: Flyvbjerg and Petersen, J. Chem. Phys. 91, 1989).
"""

from dataclasses import dataclass

import numpy as np

CONFIDENCE = 0.95

SMALLEST_BLOCK = 8
"""px, a side."""

LEAST_BLOCK_COUNT = 8
"""Fewer blocks say too little about their own scatter."""

_BIN = 0.25
"""px; wider than the errors of resting soil, narrower than what tells it from moving soil."""

_WINDOW = 1.0
"""px around the mode that the Lorentzian location looks at."""

_ITERATIONS = 50

_QUARTER = 0.3186
"""Standard deviations within which a quarter of a normal distribution lies, each way from its middle."""

_SAMPLE_SIZE = 400_000


@dataclass(frozen=True)
class Location:
    """The middle of some numbers and its 95 % interval.

    All are NaN where there are no numbers; the interval alone where they cover too few blocks.
    """

    value: float
    low: float
    high: float


UNKNOWN = Location(np.nan, np.nan, np.nan)


def median_location(field: np.ndarray) -> Location:
    """Median, and the interval between the order statistics that bound it with 95 % confidence.

    The share of values below the median would be 1/2 but for errors; by how much it errs is told by blocks.
    The interval lies between the quantiles so much below and above 1/2 (Woodruff, J. Am. Stat. Assoc. 47,
    1952). No shape of the errors is assumed.

    Parameters
    ----------
    field : (H, W) array
        NaN where there is no value.
    """
    counted = np.isfinite(field)
    values = field[counted]
    if not values.size:
        return UNKNOWN
    median = float(np.median(values))
    with np.errstate(invalid="ignore"):
        # Half of the values that are the median itself lie on either side.
        side = ((field > median).astype(np.float64) - (field < median)) / 2
    half = _half_width(side, counted) / values.size
    if not np.isfinite(half):
        return Location(median, np.nan, np.nan)
    low, high = np.quantile(values, [max(0.0, 0.5 - half), min(1.0, 0.5 + half)])
    return Location(median, float(low), float(high))


def weighted_quantiles(values: np.ndarray, weights: np.ndarray, shares: list[float]) -> np.ndarray:
    """Values below which so much of the weight lies; between two, in proportion.

    Parameters
    ----------
    values, weights : (N,) array
        At least one weight above 0.
    shares : list of float
        From 0 to 1.
    """
    order = np.argsort(values)
    weights = weights[order]
    # Each value stands in the middle of its own weight.
    below = (np.cumsum(weights) - weights / 2) / weights.sum()
    return np.interp(shares, below, values[order])


def mode_locations(fields: np.ndarray) -> tuple[Location, Location]:
    """Where most vectors lie close together, and the Lorentzian location of those around.

    The fullest cell of a histogram of both components, then in each component the centre of the Lorentzian
    (the robust norm of the paper's Eq. 3), which what lies apart hardly pulls at. It is right as long as the
    largest group of vectors that are alike is what is looked for, be it less than half of all. The interval
    is that of an M-estimator with sums over blocks.

    Parameters
    ----------
    fields : (H, W, 2) array
        Vectors in px; NaN in both where there is none.
    """
    known = np.isfinite(fields).all(axis=2)
    if not known.any():
        return UNKNOWN, UNKNOWN
    start = _fullest_cell(fields[known])
    near = known.copy()
    near[known] = (np.abs(fields[known] - start) <= _WINDOW).all(axis=1)
    return _lorentzian(fields[:, :, 0], near, start[0]), _lorentzian(fields[:, :, 1], near, start[1])


def _fullest_cell(vectors: np.ndarray) -> np.ndarray:
    """Centre of the three by three cells that hold most of (N, 2) vectors."""
    import cv2

    sample = vectors[:: 1 + len(vectors) // _SAMPLE_SIZE]
    # A few wild vectors would make the histogram large and no fuller.
    lowest, highest = np.percentile(sample, [0.5, 99.5], axis=0)
    kept = sample[((sample >= lowest) & (sample <= highest)).all(axis=1)]
    cell = np.floor((kept - lowest) / _BIN).astype(np.intp)
    shape = cell.max(axis=0) + 1
    counts = np.bincount(cell[:, 0] * shape[1] + cell[:, 1], minlength=shape.prod()).reshape(shape)
    smooth = cv2.boxFilter(
        counts.astype(np.float32), -1, (3, 3), normalize=False, borderType=cv2.BORDER_CONSTANT
    )
    fullest = np.unravel_index(int(np.argmax(smooth)), counts.shape)
    return np.asarray(lowest + (np.array(fullest) + 0.5) * _BIN)


def _lorentzian(field: np.ndarray, near: np.ndarray, start: float) -> Location:
    values = field[near].astype(np.float64)
    centre = start
    # Of the innermost quarter: further out, soil that moves a little is among the resting.
    scale = max(float(np.quantile(np.abs(values - np.median(values)), 0.25)) / _QUARTER, 1e-6)
    for _ in range(_ITERATIONS):
        weights = 1 / (1 + (values - centre) ** 2 / (2 * scale**2))
        former, centre = centre, float(weights @ values / weights.sum())
        if abs(centre - former) < 1e-6:
            break
    ratio = (values - centre) ** 2 / (2 * scale**2)
    pull = np.zeros(field.shape)
    pull[near] = (values - centre) / (1 + ratio)
    half = _half_width(pull, near) / float(((1 - ratio) / (1 + ratio) ** 2).sum())
    return Location(centre, centre - half, centre + half) if half >= 0 else Location(centre, np.nan, np.nan)


def _half_width(field: np.ndarray, counted: np.ndarray) -> float:
    """Half the 95 % interval of a field's sum, whose mean is zero: the largest that blocks of any size tell.

    NaN where there are too few blocks.
    """
    from scipy.stats import t as student

    sums, counts = _summed(field, SMALLEST_BLOCK), _summed(counted.astype(np.float64), SMALLEST_BLOCK)
    widest = np.nan
    while (block_count := int(np.count_nonzero(counts))) >= LEAST_BLOCK_COUNT:
        deviation = np.sqrt(np.square(sums).sum() * block_count / (block_count - 1))
        widest = np.fmax(widest, deviation * student.ppf((1 + CONFIDENCE) / 2, block_count - 1))
        sums, counts = _summed(sums, 2), _summed(counts, 2)
    return float(widest)


def _summed(field: np.ndarray, side: int) -> np.ndarray:
    """Sums over blocks of `side` px a side; those at the right and lower border may be smaller."""
    rows, columns = (np.arange(0, length, side) for length in field.shape)
    return np.asarray(np.add.reduceat(np.add.reduceat(field, rows, axis=0), columns, axis=1))
