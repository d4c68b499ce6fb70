"""Vectors at the nodes of a grid (PIV, subset DIC), brought to this project's conventions.

A node stays where it is: its vector is held by the pixel whose centre is nearest, together with the place it
was measured at. Nothing is interpolated, and pixels without a node are not measured.
"""

from dataclasses import dataclass, replace

import numpy as np

from soft.flow.field import FlowError, FlowField
from soft.flow.options import require_choice, require_finite

CONVENTIONS = ("forward", "midpoint")
Y_AXES = ("down", "up", "mirrored")
_SLACK = 1.0
"""So far outside of the picture a node may lie before sizes are taken not to match, px."""


@dataclass(frozen=True)
class GridConventions:
    """What a grid's numbers mean.

    Attributes
    ----------
    convention : str
        `forward`: a vector tells where what is at its node in the first picture goes. `midpoint`: it belongs
        to the middle of the way (central differences), so that it started at `x - u / 2`.
    y : str
        `down`, as in pictures; `up`, from the picture's bottom; or `mirrored`: counted down but told in
        reverse order, between the grid's own first and last row, with v upwards (OpenPIV's
        `transform_coordinates`).
    origin : float
        Coordinate of the centre of the first pixel (with `up`, of the lowest row): 0, 1 (MATLAB), or 0.5
        where the picture's edge is 0.
    """

    convention: str = "forward"
    y: str = "down"
    origin: float = 0.0

    def __post_init__(self) -> None:
        require_choice("convention", self.convention, CONVENTIONS)
        require_choice("y", self.y, Y_AXES)
        require_finite("origin", self.origin)


@dataclass(frozen=True, eq=False)
class Grid:
    """Vectors as a file has them.

    Attributes
    ----------
    x, y, u, v : (N,) float64
        Places and displacements, px.
    measured : (N,) bool
        False for nodes that were masked out, or whose vector was replaced by an interpolated one.
    """

    x: np.ndarray
    y: np.ndarray
    u: np.ndarray
    v: np.ndarray
    measured: np.ndarray

    def to_picture(self, conventions: GridConventions, height: int) -> "Grid":
        """Return the same with pixel centres at whole numbers, v down, and nodes where motion starts."""
        x, y, v = self.x - conventions.origin, self.y - conventions.origin, self.v
        if conventions.y == "up":
            y, v = height - 1 - y, -v
        elif conventions.y == "mirrored":
            y, v = y.min() + y.max() - y, -v
        if conventions.convention == "midpoint":
            x = x - np.where(np.isfinite(self.u), self.u, 0) / 2
            y = y - np.where(np.isfinite(v), v, 0) / 2
        return replace(self, x=x, y=y, v=v)


def to_field(grid: Grid, conventions: GridConventions, shape: tuple[int, int], *, name: str) -> FlowField:
    """Vectors at the pixels nearest to their nodes.

    Where two nodes share a pixel, it holds the one that was measured, and of two such the nearer one.

    Parameters
    ----------
    grid : Grid
    conventions : GridConventions
    shape : (H, W)
        Of the pictures.
    name : str
        What to call it in an error message.

    Raises
    ------
    FlowError
        If there is no node, or one lies outside the picture.
    """
    _require_inside(grid.to_picture(replace(conventions, convention="forward"), shape[0]), shape, name)
    grid = grid.to_picture(conventions, shape[0])
    measured = grid.measured & np.isfinite(grid.u) & np.isfinite(grid.v)
    column, row = np.rint(grid.x).astype(np.intp), np.rint(grid.y).astype(np.intp)
    # Written in this order, the last one stays.
    order = np.lexsort((-np.hypot(grid.x - column, grid.y - row), measured))
    inside = (column >= 0) & (column < shape[1]) & (row >= 0) & (row < shape[0])
    order = order[inside[order]]
    nodes, displacement = np.full((2, *shape, 2), np.nan)
    for target, first, second in ((nodes, grid.x, grid.y), (displacement, grid.u, grid.v)):
        target[row[order], column[order]] = np.stack([first, second], axis=-1)[order]
    valid = np.zeros(shape, bool)
    valid[row[order], column[order]] = measured[order]
    return FlowField(displacement, valid, nodes=nodes)


def _require_inside(grid: Grid, shape: tuple[int, int], name: str) -> None:
    if grid.x.size == 0:
        raise FlowError(f"{name}: holds no vectors")
    if not (np.isfinite(grid.x).all() and np.isfinite(grid.y).all()):
        raise FlowError(f"{name}: x or y is not a number at some node: places must be told for all")
    for axis, values, size in (("x", grid.x, shape[1]), ("y", grid.y, shape[0])):
        low, high = float(values.min()), float(values.max())
        if low < -0.5 - _SLACK or high > size - 0.5 + _SLACK:
            raise FlowError(
                f"{name}: nodes from {axis} = {low:g} to {high:g} px, counted from the first pixel's centre: "
                f"must lie in the picture, 0 to {size - 1} (see convention, y and origin)"
            )
