"""Cross-validation of flow against scale-invariant features, where no truth is known (section 3.2)."""

import math
from dataclasses import dataclass

import numpy as np

from soft.flow.opencv import opencv_threads

# Twice the error that bounds 95 % of a rotated plate's soil (section 3.2).
AGREEMENT_THRESHOLD = 0.56

# A match counts if the next best descriptor is this much further off (Lowe 2004, section 7.1).
RATIO = 0.8

# Rows of the table of distances that are held at a time: 80 MB for 20 000 features.
BLOCK_ROWS = 1000


@dataclass(frozen=True, eq=False)
class CrossValidation:
    """Motion of matched features by SIFT, and by flow at the nearest pixel.

    SIFT is no truth: where the two differ, either may be wrong.

    Attributes
    ----------
    points : (N, 2) float64
        x, y in px of the features in the first picture, those whose nearest pixel was measured.
    sift : (N, 2) float64
        Displacement (u, v) in px by the features' places in both pictures.
    flow : (N, 2) float64
        Displacement (u, v) in px by flow at the nearest pixel.
    error : (N,) float64
        Length of their difference in px (Eq. 7).
    agree : (N,) bool
        Whether `error` is at most `threshold`.
    threshold : float
        In px.
    keypoint_count : int
        Features found in the first picture, within the mask.
    match_count : int
        Those found again in the second, in different places.
    unmeasured_count : int
        Matches on pixels without a valid displacement: they are in no other attribute but `match_count`.
    agreement : float
        Share of the N that agree; NaN if there are none.
    """

    points: np.ndarray
    sift: np.ndarray
    flow: np.ndarray
    error: np.ndarray
    agree: np.ndarray
    threshold: float
    keypoint_count: int
    match_count: int
    unmeasured_count: int
    agreement: float

    @property
    def match_ratio(self) -> float:
        """Matches over features; NaN without features."""
        return self.match_count / self.keypoint_count if self.keypoint_count else math.nan

    @property
    def remark(self) -> str:
        """The result in words."""
        told = f"{self.match_count} of {self.keypoint_count} features matched"
        if self.unmeasured_count:
            told += f", {self.unmeasured_count} of them on pixels without a measurement"
        if not len(self.points):
            return f"{told}: nothing to compare"
        return f"{told}; flow agrees with {self.agreement:.1%} within {self.threshold:g} px"


def cross_validate(
    first: np.ndarray,
    second: np.ndarray,
    displacement: np.ndarray,
    valid: np.ndarray,
    *,
    mask: np.ndarray | None = None,
    threshold: float = AGREEMENT_THRESHOLD,
    feature_count: int = 20_000,
    threads: int | None = None,
) -> CrossValidation:
    """Compare flow with the motion of features that SIFT finds in both pictures.

    A feature's match is the nearest descriptor of the other picture, if the next one is clearly further off
    and the match holds both ways. Several features in one place count once.

    Parameters
    ----------
    first, second : (H, W) array
        Grey pictures, 0-255.
    displacement : (H, W, 2) array
        (u, v) px, forward, on the first picture's grid.
    valid : (H, W) bool
        Where it was measured.
    mask : (H, W) bool, optional
        True = use: features of the first picture elsewhere are left out. Everywhere by default.
    threshold : float, optional
        Px within which the two agree.
    feature_count : int, optional
        So many features at most in a picture, those of most contrast.
    threads : int, optional
        Threads of OpenCV; the result does not depend on them.

    Raises
    ------
    ValueError
        If shapes differ, or a number is not above 0.
    """
    mask = np.ones(first.shape, bool) if mask is None else np.asarray(mask, bool)
    _check(first, second, displacement, valid, mask)
    for name, value in (("threshold", threshold), ("feature_count", feature_count)):
        if not value > 0:
            raise ValueError(f"{name}: {value!r}: must be above 0")
    with opencv_threads(threads):
        here, described = _features(first, mask, feature_count)
        there, described_there = _features(second, None, feature_count)
    matches = _mutual_matches(described, described_there)
    points, sift = _once(here[matches[:, 0]], there[matches[:, 1]])
    column, row = _nearest(points, first.shape)
    measured = valid[row, column]
    points, sift, column, row = (a[measured] for a in (points, sift, column, row))
    flow = displacement[row, column].astype(np.float64)
    error = np.hypot(flow[:, 0] - sift[:, 0], flow[:, 1] - sift[:, 1])
    agree = error <= threshold
    return CrossValidation(
        points=points,
        sift=sift,
        flow=flow,
        error=error,
        agree=agree,
        threshold=threshold,
        keypoint_count=len(np.unique(here, axis=0)),
        match_count=len(measured),
        unmeasured_count=int((~measured).sum()),
        agreement=float(agree.mean()) if len(agree) else math.nan,
    )


def _check(
    first: np.ndarray, second: np.ndarray, displacement: np.ndarray, valid: np.ndarray, mask: np.ndarray
) -> None:
    for name, array, shape in (
        ("second", second, first.shape),
        ("displacement", displacement, (*first.shape, 2)),
        ("valid", valid, first.shape),
        ("mask", mask, first.shape),
    ):
        if array.shape != shape:
            raise ValueError(f"{name}: shape {array.shape}: must be {shape}")


def _features(
    picture: np.ndarray, mask: np.ndarray | None, feature_count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Places (N, 2) x, y in px and descriptors (N, 128), in a fixed order."""
    import cv2

    grey = np.clip(np.rint(picture), 0, 255).astype(np.uint8)
    keypoints, descriptors = cv2.SIFT.create(nfeatures=feature_count).detectAndCompute(grey, None)
    if not keypoints:
        return np.empty((0, 2)), np.empty((0, 128), np.float32)
    places = np.array([point.pt for point in keypoints], np.float64)
    angles = np.array([point.angle for point in keypoints])
    kept = np.arange(len(places))
    if mask is not None:
        column, row = _nearest(places, picture.shape)
        kept = np.flatnonzero(mask[row, column])
    order = kept[np.lexsort((angles[kept], places[kept, 0], places[kept, 1]))]
    return places[order], descriptors[order]


def _mutual_matches(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Rows that are each other's nearest and pass the ratio test: (M, 2) indices into `one` and `other`."""
    if len(one) == 0 or len(other) < 2:
        return np.empty((0, 2), np.intp)
    squares = np.square(other).sum(axis=1)
    choice, is_clear = np.empty(len(one), np.intp), np.empty(len(one), bool)
    nearest_of_other = np.full(len(other), np.inf, np.float32)
    chosen_by = np.zeros(len(other), np.intp)
    for start in range(0, len(one), BLOCK_ROWS):
        block = one[start : start + BLOCK_ROWS]
        # Descriptors are whole numbers up to 255: these sums are exact, in whatever order they are made.
        distance = np.square(block).sum(axis=1)[:, None] + squares - 2 * (block @ other.T)
        best = distance.argmin(axis=0)
        smallest = distance[best, np.arange(len(other))]
        nearer = smallest < nearest_of_other
        nearest_of_other[nearer], chosen_by[nearer] = smallest[nearer], start + best[nearer]
        rows = np.arange(len(block))
        nearest = distance.argmin(axis=1)
        least = distance[rows, nearest]
        distance[rows, nearest] = np.inf
        choice[start : start + len(block)] = nearest
        is_clear[start : start + len(block)] = least < RATIO**2 * distance.min(axis=1)
    mutual = is_clear & (chosen_by[choice] == np.arange(len(one)))
    return np.stack([np.flatnonzero(mutual), choice[mutual]], axis=1)


def _once(here: np.ndarray, there: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places and displacements without repetition, ordered by row and column.

    A place with several orientations is several features to SIFT; its matches to one and the same place tell
    the same motion.
    """
    if not len(here):
        return np.empty((0, 2)), np.empty((0, 2))
    unique = np.unique(np.concatenate([here[:, ::-1], there[:, ::-1]], axis=1), axis=0)
    return unique[:, 1::-1].copy(), unique[:, :1:-1] - unique[:, 1::-1]


def _nearest(places: np.ndarray, shape: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Column and row of the pixel nearest to each place."""
    index = np.rint(places).astype(np.intp)
    return np.clip(index[:, 0], 0, shape[1] - 1), np.clip(index[:, 1], 0, shape[0] - 1)
