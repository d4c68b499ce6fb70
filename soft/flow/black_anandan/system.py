"""Linear equations of a motion field, solved by conjugate gradients with a multigrid cycle before each step.

Grids are coarsened by blocks of 2 x 2 pixels that move as one, so that a coarse grid's equations have the
fine one's form, and a link that is cut stays cut on every grid.
"""

from dataclasses import dataclass, field

import numpy as np

_COARSEST = 64
"""Pixels of the coarsest grid, at most."""
_ITERATIONS = 200
_CHANNELS = {"tensor": 3, "links": 4, "diagonal": 3, "inverse": 3, "right": 2, "motion": 2}


@dataclass(frozen=True, eq=False)
class _Grid:
    """Arrays of one grid, each with its rim; `system_kernels` tells what they hold."""

    shape: tuple[int, int]
    tensor: np.ndarray = field(init=False)
    links: np.ndarray = field(init=False)
    diagonal: np.ndarray = field(init=False)
    inverse: np.ndarray = field(init=False)
    right: np.ndarray = field(init=False)
    motion: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        for name, count in _CHANNELS.items():
            object.__setattr__(self, name, rimmed(self.shape, count))


def rimmed(shape: tuple[int, int], count: int) -> np.ndarray:
    """Zeros for `shape` pixels, and the rim around them that kernels want."""
    from soft.flow.black_anandan.system_kernels import AFTER, BEFORE

    return np.zeros((shape[0] + BEFORE + AFTER, shape[1] + BEFORE + AFTER, count), np.float32)


class System:
    """Equations over (H, W) pixels, to be filled in and solved again and again.

    All arrays have a rim of zeros, see `system_kernels`.

    Attributes
    ----------
    tensor : (H + 3, W + 3, 3) float32
        Hold of the data on a pixel: uu, uv, vv.
    links : (H + 3, W + 3, 4) float32
        Of u and v to the right neighbour, then of u and v to the one below; zero where there is none.
    right : (H + 3, W + 3, 2) float32
        Right-hand side.
    """

    def __init__(self, shape: tuple[int, int]) -> None:
        from soft.flow.black_anandan.system_kernels import PIECE

        self._grids = [_Grid(shape)]
        while np.prod(self._grids[-1].shape) > _COARSEST:
            height, width = self._grids[-1].shape
            self._grids.append(_Grid(((height + 1) // 2, (width + 1) // 2)))
        self._sums = np.empty(shape[0] * -(-shape[1] // PIECE))
        self._applied, self._direction, self._solution = (rimmed(shape, 2) for _ in range(3))
        finest = self._grids[0]
        self.tensor, self.links, self.right = finest.tensor, finest.links, finest.right

    def prepare(self) -> None:
        """Take over what `tensor` and `links` hold now."""
        from soft.flow.black_anandan import system_kernels as kernels

        for fine, coarse in zip(self._grids, self._grids[1:], strict=False):
            kernels.coarsen(fine.tensor, fine.links, coarse.tensor, coarse.links)
        for grid in self._grids:
            kernels.prepare(grid.tensor, grid.links, grid.diagonal, grid.inverse)

    def solve(self, tolerance: float) -> np.ndarray:
        """Solve the equations; `right` becomes what is left of it.

        Ends when the norm of what is left is `tolerance` times that of the right-hand side.

        Returns
        -------
        (H, W, 2) float32
            The solution: a view, good until the next call.
        """
        from soft.flow.black_anandan import system_kernels as kernels

        finest = self._grids[0]
        self._solution.fill(0)
        self._direction.fill(0)
        start = left = self._product(finest.right, finest.right)
        before = np.inf
        for _ in range(_ITERATIONS):
            if left <= tolerance**2 * start:
                break
            self._cycle(0)
            now = self._product(finest.right, finest.motion)
            kernels.turn(finest.motion, now / before, self._direction)
            kernels.apply(finest.diagonal, finest.links, self._direction, self._applied, self._sums)
            step = now / self._sums.sum()
            kernels.step_along(self._direction, self._applied, step, self._solution, finest.right, self._sums)
            before, left = now, float(self._sums.sum())
        return self._solution[1:-2, 1:-2]

    def _product(self, one: np.ndarray, other: np.ndarray) -> float:
        from soft.flow.black_anandan import system_kernels as kernels

        kernels.product(one, other, self._sums)
        return float(self._sums.sum())

    def _cycle(self, level: int) -> None:
        """Approximate solution of a grid's equations, into its `motion` (V-cycle)."""
        from soft.flow.black_anandan import system_kernels as kernels

        grid = self._grids[level]
        if level + 1 == len(self._grids):
            grid.motion.fill(0)
            kernels.sweep(grid.inverse, grid.links, grid.right, grid.motion)
            return
        coarse = self._grids[level + 1]
        kernels.descend(grid.diagonal, grid.inverse, grid.links, grid.right, grid.motion, coarse.right)
        self._cycle(level + 1)
        kernels.ascend(grid.inverse, grid.links, grid.right, coarse.motion, grid.motion)
