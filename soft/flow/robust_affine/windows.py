"""Affine fits in Gaussian windows of several sizes, and the size that each pixel can bear.

In a window the motion is affine (the paper's Eq. 4) and the constraints are met in least squares, robustly
weighted. A second fit to what the first one left unexplained takes out most of what smoothing costs where
motion is curved ("twicing": Tukey, *Exploratory Data Analysis*, 1977): a window may be the larger for it.

Which size: each is unbiased if small enough, and the larger, the less noise. Going from small to large, the
largest is taken whose confidence interval still meets all smaller ones' (intersection of confidence
intervals: Katkovnik, Egiazarian, Astola, *J. Mathematical Imaging and Vision* 16, 2002).
"""

from dataclasses import dataclass

import numpy as np

from soft.flow.robust_affine.brightness import Constraints

_REACH = 2.5
"""Where a window ends, standard deviations."""
_MIDDLING = 2
"""The window that a jump is seen by."""
_BINOMIAL = np.array([1 / 4, 1 / 2, 1 / 4], np.float32)
_TWICED = 1.83
"""Variance of a fit with a second one to its rest / without: 4 - 4 (2/3) + 2/4 for Gaussian windows."""


@dataclass(frozen=True)
class Window:
    """A Gaussian window of standard deviation `sigma` px, fitted every `stride` px.

    A large one sums over every `thin`-th pixel each way only, after a slight smoothing of what is summed.
    """

    sigma: float
    stride: int
    thin: int = 1

    @property
    def taps(self) -> np.ndarray:
        """Weights times 1, t, t^2 along one axis, t in units of sigma: (2 R + 1, 3) float32."""
        sigma = self.sigma / self.thin
        reach = int(np.ceil(_REACH * sigma))
        t = np.arange(-reach, reach + 1) / sigma
        weight = np.exp(-t * t / 2)
        weight /= weight.sum()
        return np.stack([weight, weight * t, weight * t * t], axis=1).astype(np.float32)

    def node_count(self, shape: tuple[int, int]) -> tuple[int, int]:
        """Lines and columns of nodes on a picture of that shape."""
        return -(-shape[0] // self.stride), -(-shape[1] // self.stride)


@dataclass(frozen=True, eq=False)
class Products:
    """What windows sum, pixel by pixel: `squares` (H, W, 3) and `targets` (H, W, 2) float32."""

    squares: np.ndarray
    targets: np.ndarray

    @classmethod
    def of(cls, constraints: Constraints, noise: float, width: float, *, rest: bool = False) -> "Products":
        """With Lorentzian weights of that width in `noise`, which is in grey levels.

        `rest`: of what the present motion leaves unexplained.
        """
        from soft.flow.robust_affine import window_kernels as kernels

        shape = constraints.values.shape[:2]
        products = cls(np.empty((*shape, 3), np.float32), np.empty((*shape, 2), np.float32))
        kernels.multiply(constraints.values, noise, width, int(rest), products.squares, products.targets)
        return products

    def after(self, at_nodes: np.ndarray, stride: int) -> "Products":
        """Those of what is left once pixels have moved by the models told at nodes (lines, nodes, 6)."""
        from soft.flow.robust_affine import window_kernels as kernels

        rest = np.empty_like(self.targets)
        kernels.subtract(self.squares, self.targets, at_nodes, stride, rest)
        return Products(self.squares, rest)


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
    """

    window: Window
    at_nodes: np.ndarray
    moments: np.ndarray

    def models(self, shape: tuple[int, int]) -> np.ndarray:
        """Every pixel's: (H, W, 6) float32, blended between nodes."""
        return spread(self.at_nodes, self.window.stride, shape)

    def variance(self, noise: float) -> np.ndarray:
        """Variance by noise of u and v, fitted twice, at every node, px^2: (lines, nodes, 2) float32.

        ``noise^2 / (4 pi sigma^2)`` times the inverse of the mean of the slopes' squares: a Gaussian window
        averages over 4 pi sigma^2 px. The gradient's uncertainty does not come in: at the middle of a window
        it is independent of the motion's.
        """
        xx, xy, yy = (self.moments[:, :, k].astype(np.float64) for k in (0, 6, 12))
        determinant = np.maximum(xx * yy - xy * xy, 1e-6)
        each = noise * noise * _TWICED / (4 * np.pi * self.window.sigma**2)
        return np.minimum(np.dstack([yy, xx]) * (each / determinant)[:, :, None], 1e6).astype(np.float32)


def widened(models: np.ndarray, step: int, shape: tuple[int, int]) -> np.ndarray:
    """Models of every pixel from those of every `step`-th, whose gradients are per `step` px."""
    wide = models.copy()
    for k in (1, 2, 4, 5):
        wide[:, :, k] /= step
    return spread(wide, step, shape)


def repeated(values: np.ndarray, step: int, shape: tuple[int, int]) -> np.ndarray:
    """Values of every `step`-th pixel each way for all of a picture of that shape: the upper left one's."""
    return values.repeat(step, axis=0).repeat(step, axis=1)[: shape[0], : shape[1]]


def spread(at_nodes: np.ndarray, stride: int, shape: tuple[int, int]) -> np.ndarray:
    """Models of every pixel, (H, W, 6) float32, from those of every `stride`-th."""
    from soft.flow.robust_affine import window_kernels as kernels

    models = np.empty((*shape, 6), np.float32)
    kernels.spread(at_nodes, stride, models)
    return models


def fit(products: Products, window: Window, held: np.ndarray, *, twice: bool = False) -> Fit:
    """Fit an affine motion in the window around every node.

    Parameters
    ----------
    products : Products
    window : Window
    held : (H, W, 6) float32
        Where texture tells nothing, motion stays as it is here.
    twice : bool, optional
        Add a fit to what the first one leaves.
    """
    moments = _moments(products.squares, window)
    held_there = np.ascontiguousarray(held[:: window.stride, :: window.stride])
    at_nodes = _solved(products.targets, window, moments, held_there)
    if twice:
        rest = products.after(at_nodes, window.stride)
        at_nodes += _solved(rest.targets, window, moments, np.zeros_like(at_nodes))
    return Fit(window, at_nodes, moments)


def _moments(squares: np.ndarray, window: Window) -> np.ndarray:
    from soft.flow.robust_affine import window_kernels as kernels

    lines, nodes = window.node_count(squares.shape[:2])
    squares, stride = _thinned(squares, window.thin), window.stride // window.thin
    taps, sums = window.taps, np.empty((squares.shape[0], nodes, 9), np.float32)
    kernels.sum_squares_along_rows(squares, taps, stride, sums)
    moments = np.empty((lines, nodes, 18), np.float32)
    kernels.sum_squares_along_columns(sums, taps, stride, moments)
    return moments


def _solved(targets: np.ndarray, window: Window, moments: np.ndarray, held: np.ndarray) -> np.ndarray:
    from soft.flow.robust_affine import window_kernels as kernels

    lines, nodes = moments.shape[:2]
    targets, stride = _thinned(targets, window.thin), window.stride // window.thin
    taps, sums = window.taps, np.empty((targets.shape[0], nodes, 4), np.float32)
    kernels.sum_targets_along_rows(targets, taps, stride, sums)
    rights = np.empty((lines, nodes, 6), np.float32)
    kernels.sum_targets_along_columns(sums, taps, stride, rights)
    at_nodes = np.empty((lines, nodes, 6), np.float32)
    kernels.solve_nodes(moments, rights, window.sigma, held, at_nodes)
    return at_nodes


def _thinned(products: np.ndarray, thin: int) -> np.ndarray:
    import cv2

    if thin == 1:
        return products
    smooth = cv2.sepFilter2D(products, -1, _BINOMIAL, _BINOMIAL, borderType=cv2.BORDER_REFLECT_101)
    return np.ascontiguousarray(smooth[::thin, ::thin])


@dataclass(frozen=True, eq=False)
class Chosen:
    """What each pixel's largest bearable window found.

    Attributes
    ----------
    models : (H, W, 6) float32
    variance : (H, W, 2) float32
        Of u and v by the pictures' noise, px^2.
    level : (H, W) int32
        Which window, from the smallest on.
    smallest : (H, W, 2) float32
        u and v that the smallest window found.
    smallest_variance : (H, W, 2) float32
        Of them.
    jump : (H, W) float32
        How far the smallest and a middling window's fits lie apart beyond what noise makes likely, px.
    """

    models: np.ndarray
    variance: np.ndarray
    level: np.ndarray
    smallest: np.ndarray
    smallest_variance: np.ndarray
    jump: np.ndarray

    def widened(self, step: int, shape: tuple[int, int]) -> "Chosen":
        """From every `step`-th pixel to all of a picture of that shape."""
        others = (self.variance, self.level, self.smallest, self.smallest_variance, self.jump)
        return Chosen(
            widened(self.models, step, shape), *(repeated(values, step, shape) for values in others)
        )


def choose(
    products: Products, windows: tuple[Window, ...], held: np.ndarray, *, noise: float, confidence: float
) -> Chosen:
    """Fit in windows of every size and let each pixel take the largest it can bear.

    Parameters
    ----------
    windows : tuple of Window
        From small to large.
    noise : float
        Of an equation, grey levels; see `Fit.variance`.
    confidence : float
        Half the width of the intervals, standard deviations.
    """
    from soft.flow.robust_affine import window_kernels as kernels

    shape = held.shape[:2]
    pairs = (*shape, 2)
    intervals = np.tile(np.array([-np.inf, np.inf], np.float32), pairs)
    models, variance, level_of = held.copy(), np.zeros(pairs, np.float32), np.full(shape, -1, np.int32)
    smallest, motions = np.empty(pairs, np.float32), np.empty(pairs, np.float32)
    smallest_variance, jump = variance, np.zeros(shape, np.float32)
    for level, window in enumerate(windows):
        found = fit(products, window, held, twice=True)
        kernels.take_agreeing(
            found.at_nodes, found.variance(noise), window.stride, confidence, level, intervals,
            motions if level else smallest, models, variance, level_of,
        )  # fmt: skip
        if level == 0:
            smallest_variance = variance.copy()
        if level == _MIDDLING:
            apart = np.abs(motions - smallest) - 3 * np.sqrt(smallest_variance)
            np.maximum(apart[:, :, 0], apart[:, :, 1], out=jump)
    return Chosen(models, variance, level_of, smallest, smallest_variance, jump)
