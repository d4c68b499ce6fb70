"""Soil or not, moving or not: k-means with two classes, and the largest region made whole (section 2.3)."""

import math
from dataclasses import dataclass

import numpy as np

from soft.growth import grown
from soft.illumination import flatten_illumination

# Of the histogram that classes are fitted on: fine against any class.
BIN_COUNT = 4096

# Shares of the values below the two centres that k-means starts from: two halves, and small classes above.
STARTS = ((0.25, 0.75), (0.5, 0.95), (0.5, 0.995), (0.05, 1.0))

# Distance of the class centres over the sum of the classes' standard deviations. Two-means cuts any single
# heap somewhere: a normal one to 1.3, a flat one to 1.7. From 2 the classes stand apart.
LEAST_SEPARATION = 2.0

# px. Twice the 0.3 px that bound 95 % of the errors on a rotated plate (section 3.1.1): below it, what
# two-means finds is the error's own spread.
LEAST_SPEED_STEP = 0.6

# px. Within this distance of the soil's outline, flow may be that of the implement, or of both. Such speeds
# are few and large, and would shift the classes.
OUTLINE_MARGIN = 3

# Of the pixels called moving, this share must hang together: errors are scattered, a moving mass is not.
LEAST_REGION_SHARE = 0.25

# A mass that is this share of the largest one moves, too. A wheel moves soil ahead of it and behind; whether
# a thread joins the two is chance, and must not decide whether half of what moves is counted.
LEAST_MASS_SHARE = 0.1

# What is moving at one pixel says something about a pixel this share of the shorter side away (about 25 px,
# more than errors of flow hang together). By chance the coherence is 0, within one large mass 1.
COHERENCE_DISTANCE = 0.05
LEAST_COHERENCE = 0.25

# Fast pixels that are no mass, and not more than this share of the soil, are set aside as wrong vectors, and
# the rest is split again: a few vectors of tens of px would hide a mass that moves by one.
MOST_SET_ASIDE = 0.05

SOIL_CHOICES = ("bright", "dark", "all")


@dataclass(frozen=True)
class TwoMeans:
    """Two classes of a scalar; a value belongs to the nearer centre, so `threshold` lies half-way.

    `separation` is the distance of the centres over the sum of the standard deviations; infinite for two
    values, zero where there are not even two.
    """

    low: float
    high: float
    threshold: float
    separation: float


@dataclass(frozen=True, eq=False)
class SoilRegion:
    """Where soil is.

    Attributes
    ----------
    mask : (H, W) bool
        True on soil.
    found : bool
        False if the grey levels show no two classes; the whole picture then counts as soil.
    remark : str
        What was found, in words.
    """

    mask: np.ndarray
    found: bool
    remark: str


@dataclass(frozen=True, eq=False)
class MovingRegion:
    """Where soil moves, in the inertial frame: one mass or several; its boundary is the shear interface.

    Attributes
    ----------
    mask : (H, W) bool
        True on moving soil, empty if `found` is False.
    found : bool
        False if the speeds show no moving mass.
    remark : str
        What was found, in words.
    threshold : float
        Speed in px that parts moving from resting soil; NaN if `found` is False.
    """

    mask: np.ndarray
    found: bool
    remark: str
    threshold: float = math.nan


def soil_mask(picture: np.ndarray, *, soil: str = "bright", seed: int = 0) -> SoilRegion:
    """Tell soil from implement and background by grey level.

    Two-means on the grey levels, the largest region of the soil's class, its gaps filled. Grains and gaps
    between them are smoothed away first by a median filter. Where the light falls off so much that the grey
    levels of the whole picture show no two classes, a smooth illumination is divided out before they are
    looked for again.

    Parameters
    ----------
    picture : (H, W) array
        Grey, 0-255.
    soil : str, optional
        `bright` (light soil, dark implement and background), `dark`, or `all` (the picture shows nothing
        else).
    seed : int, optional
        Of k-means, as in `two_means`.

    Raises
    ------
    ValueError
        If `soil` is another word.
    """
    if soil not in SOIL_CHOICES:
        raise ValueError(f"soil: {soil!r}: allowed are {', '.join(SOIL_CHOICES)}")
    if soil == "all":
        return SoilRegion(np.ones(picture.shape, bool), True, "the whole picture is soil, as asked for")
    size = texture_size(picture.shape)
    smooth = _without_texture(picture, size)
    for grey, how in ((smooth, "grey level"), (flatten_illumination(smooth), "grey level over illumination")):
        classes = two_means(grey, seed=seed)
        if classes.separation >= LEAST_SEPARATION:
            raw = grey > classes.threshold if soil == "bright" else grey <= classes.threshold
            mask = largest_region(raw, size=size)
            return SoilRegion(mask, True, f"soil by {how}: classes {classes.separation:.1f} apart")
    return SoilRegion(
        np.ones(picture.shape, bool), False, "grey levels show no two classes: all counts as soil"
    )


def moving_mask(
    speed: np.ndarray,
    soil: np.ndarray,
    *,
    seed: int = 0,
    least_step: float = LEAST_SPEED_STEP,
    reach: float = 0.0,
) -> MovingRegion:
    """Tell moving from resting soil by speed in the inertial frame.

    Two-means on the speeds over soil; of the faster class, the largest region and all that are at least a
    tenth of it, their gaps filled. (The paper takes the largest alone. Where a wheel moves one mass ahead and
    one behind, it then jumps by a whole mass whenever a thread between the two breaks.) Two-means splits any
    numbers, also the errors of a field in which nothing moves. So the region is empty unless the classes lie
    `least_step` apart and the faster class is a mass: enough of it hangs together, and moving pixels have
    moving pixels some way off. A few fast pixels that are no mass are set aside, and the rest is split again.
    Classes are fitted without the pixels nearest to the soil's outline, as flow may be the implement's there.

    Parameters
    ----------
    speed : (H, W) array
        Magnitude of inertial displacement in px, NaN where it was not measured.
    soil : (H, W) bool
        Where soil is.
    seed : int, optional
        Of k-means, as in `two_means`.
    least_step : float, optional
        Px that the classes must be apart at least. The default suits single pairs; a mean over many pairs has
        smaller errors, and shows motion that single pairs do not.
    reach : float, optional
        Px over which errors hang together although they are no motion, as between the nodes of a grid: what
        is fast must be so further off.
    """
    measured = soil & np.isfinite(speed)
    within = ~grown(~soil, OUTLINE_MARGIN)
    most = MOST_SET_ASIDE * measured.sum()
    set_aside = 0
    while True:
        inner = measured & within
        classes = two_means(speed[inner if inner.any() else measured], seed=seed)
        step = classes.high - classes.low
        told = f"; {set_aside} scattered fast pixels set aside" if set_aside else ""
        if step < least_step:
            return _nothing_moves(soil, f"speeds differ by {step:.2f} px, which errors alone may do{told}")
        # NaN is not above any threshold.
        fast = measured & (np.nan_to_num(speed) > classes.threshold)
        size = texture_size(soil.shape)
        why = _why_no_mass(largest_region(fast, size=size), fast, measured, reach)
        if why is None:
            mask = large_regions(fast, size=size, share=LEAST_MASS_SHARE) & soil
            return MovingRegion(mask, True, _told_apart(classes) + told, classes.threshold)
        set_aside += int(fast.sum())
        if set_aside > most:
            return _nothing_moves(soil, why)
        measured &= ~fast


def _told_apart(classes: TwoMeans) -> str:
    """Say how far moving and resting soil are apart, and whether there is a step between them at all."""
    told = f"moving and resting soil {classes.high - classes.low:.2f} px apart"
    if classes.separation >= LEAST_SEPARATION:
        return told
    return f"{told}, with all speeds between: the line is where the speed is {classes.threshold:.2f} px"


def _why_no_mass(region: np.ndarray, fast: np.ndarray, measured: np.ndarray, reach: float) -> str | None:
    """Say why fast pixels are no moving mass; None if they are one."""
    share = float((region & fast).sum() / fast.sum())
    if share < LEAST_REGION_SHARE:
        return f"the largest region holds {share:.0%} of the fast pixels: they are scattered"
    distance = max(1, round(COHERENCE_DISTANCE * min(fast.shape)), math.ceil(2 * reach))
    found = coherence(fast, measured, distance)
    if found < LEAST_COHERENCE:
        return f"fast pixels have hardly more fast ones {distance} px off than chance gives: scattered"
    return None


def coherence(fast: np.ndarray, measured: np.ndarray, distance: int) -> float:
    """How much more often than by chance pixels `distance` px beside or below a fast one are fast, too.

    Parameters
    ----------
    fast, measured : (H, W) bool
        Fast pixels, among those measured.
    distance : int
        In px.

    Returns
    -------
    float
        0 by chance, 1 if all are; 1 where every measured pixel is fast.
    """
    both = pairs = 0
    for here, there in (
        ((slice(None), slice(None, -distance)), (slice(None), slice(distance, None))),
        ((slice(None, -distance), slice(None)), (slice(distance, None), slice(None))),
    ):
        known = measured[here] & measured[there]
        both += 2 * int((known & fast[here] & fast[there]).sum())
        pairs += int((known & fast[here]).sum() + (known & fast[there]).sum())
    chance = float(fast.sum() / measured.sum()) if measured.any() else 1.0
    if chance == 1.0:
        return 1.0
    return (both / pairs - chance) / (1 - chance) if pairs else 0.0


def _nothing_moves(soil: np.ndarray, why: str) -> MovingRegion:
    return MovingRegion(np.zeros(soil.shape, bool), False, f"no moving region: {why}")


def two_means(values: np.ndarray, *, seed: int) -> TwoMeans:
    """K-means with k = 2 on a scalar.

    Values are sorted into a fine histogram first, so that all of them count and it takes no longer for many.
    From several starts, the parting with the least sum of squared distances to the class means is taken: a
    single random start misses a small class.

    Parameters
    ----------
    values : array
        Finite, any shape.
    seed : int
        Of k-means, should a class become empty.
    """
    values = values.ravel().astype(np.float64)
    if values.size == 0 or values.min() == values.max():
        only = float(values[0]) if values.size else 0.0
        return TwoMeans(only, only, only, 0.0)
    above = values > _parting(values, seed)
    # Of the values themselves, not of the histogram's bins.
    low, high = float(values[~above].mean()), float(values[above].mean())
    spread = values[above].std() + values[~above].std()
    separation = (high - low) / spread if spread > 0 else np.inf
    return TwoMeans(low, high, (low + high) / 2, float(separation))


def _parting(values: np.ndarray, seed: int) -> float:
    """The value half-way between the two classes' centres."""
    from sklearn.cluster import KMeans
    from threadpoolctl import threadpool_limits

    counts, edges = np.histogram(values, BIN_COUNT)
    filled = counts > 0
    places, weights = ((edges[1:] + edges[:-1]) / 2)[filled, None], counts[filled]
    # One thread: sums come in one order everywhere, and so few numbers are not worth more.
    with threadpool_limits(1):
        starts = [np.quantile(values, shares)[:, None] for shares in STARTS]
        solvers = [KMeans(2, init=start, n_init=1, tol=0.0, random_state=seed) for start in starts]
        fits = [solver.fit(places, sample_weight=weights) for solver in solvers]
    best = min(fits, key=lambda fit: fit.inertia_)
    return float(best.cluster_centers_.mean())


def texture_size(shape: tuple[int, ...]) -> int:
    """Px over which grains are smoothed away: odd, a 120th of the shorter side, 5 at least."""
    return max(5, 2 * round(min(shape) / 240) + 1)


def largest_region(raw: np.ndarray, *, size: int) -> np.ndarray:
    """Fill gaps narrower than about `size` px in the largest connected region: (H, W) bool from (H, W) bool.

    Dilation and erosion close gaps, erosion and dilation cut off threads; then what is enclosed and smaller
    than `size` squared times ten is filled. An implement inside the soil is larger and stays out.
    """
    return large_regions(raw, size=size, share=1.0)


def large_regions(raw: np.ndarray, *, size: int, share: float) -> np.ndarray:
    """Do as `largest_region`, with all regions that have at least this share of the largest one's area."""
    import cv2

    disc = _disc(size)
    closed = cv2.morphologyEx(raw.astype(np.uint8), cv2.MORPH_CLOSE, disc)
    opened = cv2.morphologyEx(closed, cv2.MORPH_OPEN, disc)
    return _without_holes(_largest_components(opened, share), size)


def without_gaps(raw: np.ndarray, *, size: int) -> np.ndarray:
    """Fill gaps as `largest_region` does, and leave everything else as it is."""
    import cv2

    closed = cv2.morphologyEx(raw.astype(np.uint8), cv2.MORPH_CLOSE, _disc(size))
    return _without_holes(closed > 0, size)


def _disc(size: int) -> np.ndarray:
    import cv2

    return np.asarray(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size)))


def _without_holes(mask: np.ndarray, size: int) -> np.ndarray:
    return ~_without_specks(~mask, 10 * size * size)


def _largest_components(binary: np.ndarray, share: float) -> np.ndarray:
    """Only the components of at least this share of the largest one; with a share of 1, one of them."""
    import cv2

    count, labels, stats, _ = cv2.connectedComponentsWithStats(binary.astype(np.uint8), connectivity=4)
    if count < 2:
        return np.zeros(binary.shape, bool)
    area = stats[:, cv2.CC_STAT_AREA].copy()
    area[0] = 0
    kept = np.arange(count) == int(np.argmax(area)) if share == 1.0 else area >= share * area.max()
    return np.asarray(kept[np.asarray(labels, np.intp)])


def _without_specks(binary: np.ndarray, least_area: int) -> np.ndarray:
    """Only the components of at least `least_area` px."""
    import cv2

    _, labels, stats, _ = cv2.connectedComponentsWithStats(binary.astype(np.uint8), connectivity=8)
    kept = np.asarray(stats[:, cv2.CC_STAT_AREA] >= least_area)
    kept[0] = False
    return kept[np.asarray(labels, np.intp)]


def _without_texture(picture: np.ndarray, size: int) -> np.ndarray:
    """Median over `size` px, which keeps edges where they are; 8 bits are plenty to tell two classes."""
    import cv2

    return cv2.medianBlur(np.clip(np.rint(picture), 0, 255).astype(np.uint8), size).astype(np.float32)
