"""Affine fits in Gaussian windows of several sizes, and the size that each pixel can bear.

In a window the motion is affine (the paper's Eq. 4) and the constraints are met in least squares, robustly
weighted. A second fit to what the first one left unexplained takes out most of what smoothing costs where
motion is curved ("twicing": Tukey, *Exploratory Data Analysis*, 1977): a window may be the larger for it.

Which size: each is unbiased if small enough, and the larger, the less noise. Going from small to large, the
largest is taken whose confidence interval still meets all smaller ones' (intersection of confidence
intervals: Katkovnik, Egiazarian, Astola, *J. Mathematical Imaging and Vision* 16, 2002). At one place such
intervals miss what is well below the noise; so a larger window is taken only where, on average around a
place, what it finds otherwise is less than the noise it saves.
"""

from dataclasses import dataclass, replace

import numpy as np

from soft.flow.robust_affine.brightness import Constraints

_REACH = 2.5
"""Where a window ends, standard deviations."""
_LEAST_PLACES = 2.0
"""A window that is at least so many places wide, as standard deviation, may sum over twice as few."""
_MIDDLING = 2
"""The window that a jump is seen by."""
_LEAST_JUDGED = 3.0
"""Standard deviation of windows from which on larger ones are judged around a place, px."""
_JUDGED_WITHIN = 1.5
"""Standard deviation of the window in which that is done / the smaller window's."""
_LEAST_WITHIN = 1.0
"""The same, nodes, for nodes far apart."""
_DEARER = 0.8
"""What a window must save, as variance, for what it costs,"""
_MOST_DEAR = 4.0
"""of which so much counts at most at one place: else breaks of the motion would spoil what lies around."""
_MEASURED = 1.0
"""Variance by noise below which a window has pixels to use, px^2."""
_BLUR = 1 / 2
"""Variance of a place's shares in those around it, squared places."""
_FURTHER = 2.0
"""How much of a second fit's rest is taken where motion bends: a third one's and so on go the same way."""
_BENT = 0.04
"""There a fit's rest, root mean square, must be larger than this, px,"""
_BEYOND_NOISE = 1.0
"""and than what noise makes of it: this is the factor on that variance."""
_TINY = 1e-9
"""Px^2."""
_BENT_WITHIN = 2.0
"""Standard deviation of the window in which that is judged, nodes."""
_CALM = 0.27
"""A fit's rest is taken less where it is no more than this share of its variance by noise."""
_TWICED = 1.83
"""Variance of a fit with a second one to its rest / without: 4 - 4 (2/3) + 2/4 for Gaussian windows."""


@dataclass(frozen=True)
class Window:
    """A Gaussian window of standard deviation `sigma` px, fitted every `stride` px."""

    sigma: float
    stride: int


@dataclass(frozen=True, eq=False)
class Products:
    """What windows sum, at places on a square grid.

    Attributes
    ----------
    squares : (h, w, 3) float32
    targets : (h, w, 2) float32
    step : int
        From place to place, px.
    spacing : int
        From equation to equation, px: less than `step` where a place stands for several.
    blur : float
        Variance of the smoothing by which it does so, px^2.
    """

    squares: np.ndarray
    targets: np.ndarray
    step: int
    spacing: int
    blur: float = 0.0

    @classmethod
    def of(cls, constraints: Constraints, noise: float, width: float, *, rest: bool = False) -> "Products":
        """With Lorentzian weights of that width in `noise`, which is in grey levels.

        `rest`: of what the present motion leaves unexplained.
        """
        from soft.flow.robust_affine import window_kernels as kernels

        shape, step = constraints.values.shape[:2], constraints.step
        products = cls(np.empty((*shape, 3), np.float32), np.empty((*shape, 2), np.float32), step, step)
        stretch = constraints.stretch
        kernels.multiply(
            constraints.values, noise, width, stretch, int(rest), products.squares, products.targets
        )
        return products

    def gathered(self) -> "Products":
        """At every second place each way, each of which stands for those around it, too.

        Their shares keep sums of products times 1, x and y as they are.
        """
        squares, targets = _gathered(self.squares), _gathered(self.targets)
        blur = self.blur + _BLUR * self.step**2
        return replace(self, squares=squares, targets=targets, step=2 * self.step, blur=blur)

    def after(self, at_nodes: np.ndarray, stride: int) -> "Products":
        """Those of what is left once places have moved by the models told at nodes (lines, nodes, 6)."""
        from soft.flow.robust_affine import window_kernels as kernels

        rest = np.empty_like(self.targets)
        kernels.subtract(self.squares, self.targets, at_nodes, stride // self.step, self.step, rest)
        return replace(self, targets=rest)

    def taps(self, sigma: float) -> np.ndarray:
        """Weights of a window times 1, t, t^2 along one axis, t in units of sigma: (2 R + 1, 3) float32."""
        own = np.sqrt(sigma**2 - self.blur) / self.step
        reach = int(np.ceil(_REACH * own))
        places = np.arange(-reach, reach + 1)
        weight = np.exp(-((places / own) ** 2) / 2)
        weight /= weight.sum()
        t = places * (self.step / sigma)
        return np.stack([weight, weight * t, weight * t * t], axis=1).astype(np.float32)

    def suit(self, window: Window) -> bool:
        """Tell whether half as many places each way would do for a window."""
        blur = self.blur + _BLUR * self.step**2
        wide = window.sigma**2 - blur >= (2 * self.step * _LEAST_PLACES) ** 2
        return wide and window.stride % (2 * self.step) == 0


@dataclass(frozen=True, eq=False)
class Fit:
    """Affine motions at the nodes of a window.

    Attributes
    ----------
    window : Window
    at_nodes : (lines, nodes, 6) float32
        u, ux, uy, v, vx, vy: px and px/px.
    moments : (lines, nodes, 18) float32
        Sums of the squares over the windows, times 1, x, y, xx, xy, yy each.
    spacing : int
        From equation to equation, px.
    """

    window: Window
    at_nodes: np.ndarray
    moments: np.ndarray
    spacing: int

    def models(self, shape: tuple[int, int], step: int) -> np.ndarray:
        """Those of places `step` px apart: (h, w, 6) float32, blended between nodes."""
        return spread(self.at_nodes, self.window.stride, shape, step)

    def add_to(self, models: np.ndarray, where: np.ndarray) -> None:
        """Add those of every pixel to `models` (H, W, 6) where that is true, (H, W) bool."""
        from soft.flow.robust_affine import window_kernels as kernels

        kernels.add_spread(self.at_nodes, self.window.stride, where.view(np.uint8), models)

    def variance(self, noise: float) -> np.ndarray:
        """Variance by noise of u and v, fitted twice, at every node, px^2: (lines, nodes, 2) float32.

        ``noise^2 / (4 pi sigma^2)`` times the inverse of the mean of the slopes' squares: a Gaussian window
        averages over 4 pi sigma^2 px. The gradient's uncertainty does not come in: at the middle of a window
        it is independent of the motion's.
        """
        from soft.flow.robust_affine import window_kernels as kernels

        each = noise * noise * _TWICED * self.spacing**2 / (4 * np.pi * self.window.sigma**2)
        variance = np.empty((*self.moments.shape[:2], 2), np.float32)
        kernels.tell_variance(self.moments, each, variance)
        return variance


def repeated(values: np.ndarray, step: int, shape: tuple[int, int]) -> np.ndarray:
    """Values of every `step`-th pixel each way for all of a picture of that shape: the upper left one's."""
    import cv2

    height, width = values.shape[:2]
    size = (width * step, height * step)
    bytes_of = values.view(np.uint8) if values.dtype == bool else values
    large = cv2.resize(bytes_of, size, interpolation=cv2.INTER_NEAREST)[: shape[0], : shape[1]]
    return large.view(values.dtype)


def spread(at_nodes: np.ndarray, stride: int, shape: tuple[int, int], step: int = 1) -> np.ndarray:
    """Models of a grid of that shape, places `step` px apart, from nodes `stride` px apart."""
    from soft.flow.robust_affine import window_kernels as kernels

    models = np.empty((*shape, 6), np.float32)
    kernels.spread(at_nodes, stride // step, step, models)
    return models


def fit(products: Products, window: Window, held: np.ndarray | None = None, *, twice: bool = False) -> Fit:
    """Fit an affine motion in the window around every node.

    Parameters
    ----------
    products : Products
    window : Window
    held : (h, w, 6) float32, optional
        Where texture tells nothing, motion stays as it is here, at the products' places. Default: at rest.
    twice : bool, optional
        Add a fit to what the first one leaves.
    """
    stride = window.stride // products.step
    moments = _moments(products, window)
    rest = np.zeros((*moments.shape[:2], 6), np.float32)
    held_there = rest if held is None else np.ascontiguousarray(held[::stride, ::stride])
    at_nodes = _solved(products, window, moments, held_there)
    if twice:
        at_nodes += _solved(products.after(at_nodes, window.stride), window, moments, rest)
    return Fit(window, at_nodes, moments, products.spacing)


def fit_rest(products: Products, window: Window, noise: float) -> Fit:
    """Fit what the present motion leaves; further, to the rest of the rest, where it is more than noise.

    Each fit leaves a share of what bends within its window; each also adds noise, so most places do with one.

    Parameters
    ----------
    products : Products
        Of what is left.
    window : Window
    noise : float
        Of an equation, grey levels.
    """
    import cv2

    found = fit(products, window)
    once = found.at_nodes
    further = _solved(products.after(once, window.stride), window, found.moments, np.zeros_like(once))
    square = cv2.GaussianBlur(once[:, :, 0] ** 2 + once[:, :, 3] ** 2, (0, 0), _BENT_WITHIN)
    by_noise = np.minimum(found.variance(noise).sum(axis=2), 1)
    sure = np.clip(1 - _CALM * by_noise / np.maximum(square, _TINY), 0, 1)
    more = np.clip(square / (_BENT**2 + _BEYOND_NOISE * by_noise) - 1, 0, 1)
    return replace(found, at_nodes=sure[:, :, None] * once + _FURTHER * more[:, :, None] * further)


def _bearable(smaller: tuple[Fit, np.ndarray] | None, larger: Fit) -> np.ndarray:
    """Tell at which nodes a window saves more noise than it costs: (lines, nodes) uint8, 0 or 1.

    The smaller window's fits come with their variance.

    With f and F what the smaller and the larger one find, v the variance of f and c its covariance with F:
    motion that F smoothes away adds E (F - f)^2 - (v + V - 2 c) to its squared error, and it saves v - V.
    """
    import cv2

    if smaller is None or smaller[0].window.sigma < _LEAST_JUDGED:
        return np.ones(larger.at_nodes.shape[:2], np.uint8)
    found, variance = smaller
    every = larger.window.stride // found.window.stride
    some = (slice(None, None, every), slice(None, None, every))
    variance = variance[some].sum(axis=2)
    apart = np.square(larger.at_nodes[:, :, ::3] - found.at_nodes[some][:, :, ::3]).sum(axis=2)
    saved = 2 * (1 - _shared(found.window.sigma, larger.window.sigma)) * variance
    cost = np.minimum(apart / (_DEARER * saved + _TINY), _MOST_DEAR)
    measured = (variance < _MEASURED).astype(np.float32)
    within = max(_JUDGED_WITHIN * found.window.sigma / larger.window.stride, _LEAST_WITHIN)
    total, share = (cv2.GaussianBlur(each, (0, 0), within) for each in (measured * cost, measured))
    return (total <= share).astype(np.uint8)


def _shared(smaller: float, larger: float) -> float:
    """Covariance of two windows' fits by noise / variance of the smaller's, from their standard deviations.

    A fit with a second one to its rest sums with 2 g - g * g, g the Gaussian window.
    """

    def overlap(a: float, b: float) -> float:
        parts = ((2, 1), (-1, 2))
        return sum(p * q / (i * a * a + j * b * b) for p, i in parts for q, j in parts)

    return overlap(smaller, larger) / overlap(smaller, smaller)


def _moments(products: Products, window: Window) -> np.ndarray:
    from soft.flow.robust_affine import window_kernels as kernels

    height, width = products.squares.shape[:2]
    stride, taps = window.stride // products.step, products.taps(window.sigma)
    lines, nodes = -(-height // stride), -(-width // stride)
    sums, moments = np.empty((height, nodes, 9), np.float32), np.empty((lines, nodes, 18), np.float32)
    kernels.sum_squares_along_rows(products.squares, taps, stride, sums)
    kernels.sum_squares_along_columns(sums, taps, stride, moments)
    return moments


def _solved(products: Products, window: Window, moments: np.ndarray, held: np.ndarray) -> np.ndarray:
    from soft.flow.robust_affine import window_kernels as kernels

    lines, nodes = moments.shape[:2]
    stride, taps = window.stride // products.step, products.taps(window.sigma)
    sums = np.empty((products.targets.shape[0], nodes, 4), np.float32)
    kernels.sum_targets_along_rows(products.targets, taps, stride, sums)
    rights, at_nodes = (np.empty((lines, nodes, 6), np.float32) for _ in range(2))
    kernels.sum_targets_along_columns(sums, taps, stride, rights)
    kernels.solve_nodes(moments, rights, window.sigma, held, at_nodes)
    return at_nodes


def _gathered(products: np.ndarray) -> np.ndarray:
    from soft.flow.robust_affine import window_kernels as kernels

    height, width, channels = products.shape
    gathered = np.empty((-(-height // 2), -(-width // 2), channels), np.float32)
    kernels.gather(products, gathered)
    return gathered


@dataclass(frozen=True, eq=False)
class Chosen:
    """What the largest bearable window found at every place of a grid.

    Attributes
    ----------
    models : (h, w, 6) float32
    variance : (h, w, 2) float32
        Of u and v by the pictures' noise, px^2.
    level : (h, w) int32
        Which window, from the smallest on.
    excess : (h, w, 2) float32
        Square of what the next smaller window found otherwise, less what noise makes of it, px^2.
    jump : (h, w) float32
        How far the smallest and a middling window's fits lie apart beyond what noise makes likely, px.
    step : int
        From place to place, px.
    sizes : tuple of float
        The windows' standard deviations, px.
    """

    models: np.ndarray
    variance: np.ndarray
    level: np.ndarray
    excess: np.ndarray
    jump: np.ndarray
    step: int
    sizes: tuple[float, ...]

    def spread(self, shape: tuple[int, int]) -> np.ndarray:
        """Models of all of a picture of that shape: (H, W, 6) float32."""
        return spread(self.models, self.step, shape)


def choose(
    products: Products,
    windows: tuple[Window, ...],
    held: np.ndarray,
    *,
    stride: int,
    noise: float,
    confidence: float,
) -> Chosen:
    """Fit in windows of every size and let each place take the largest it can bear.

    Parameters
    ----------
    windows : tuple of Window
        From small to large.
    held : (h, w, 6) float32
        See `fit`.
    stride : int
        Every so many of the products' places chooses.
    noise : float
        Of an equation, grey levels; see `Fit.variance`.
    confidence : float
        Half the width of the intervals, standard deviations.
    """
    from soft.flow.robust_affine import window_kernels as kernels

    models, step = held[::stride, ::stride].copy(), stride * products.step
    shape = models.shape[:2]
    pairs = (*shape, 2)
    intervals = np.tile(np.array([-np.inf, np.inf], np.float32), pairs)
    variance, level_of = np.zeros(pairs, np.float32), np.full(shape, -1, np.int32)
    excess, smallest, motions = (np.zeros(pairs, np.float32) for _ in range(3))
    jump, smaller, smallest_variance = np.zeros(shape, np.float32), None, variance
    for level, window in enumerate(windows):
        while products.suit(window):
            products, held = products.gathered(), held[::2, ::2]
        found = fit(products, window, held, twice=True)
        larger = (found, found.variance(noise))
        kernels.take_agreeing(
            found.at_nodes, larger[1], _bearable(smaller, found), window.stride // step, step, confidence,
            level, intervals, motions if level else smallest, models, variance, excess, level_of,
        )  # fmt: skip
        smaller = larger
        if level == 0:
            smallest_variance = variance.copy()
        if level == _MIDDLING:
            apart = np.abs(motions - smallest) - 3 * np.sqrt(smallest_variance)
            np.maximum(apart[:, :, 0], apart[:, :, 1], out=jump)
    sizes = tuple(window.sigma for window in windows)
    return Chosen(models, variance, level_of, excess, jump, step, sizes)
