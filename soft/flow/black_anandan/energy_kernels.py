"""Kernels: the energy's equations, weighted by the slopes of its penalties.

Every number has one writer, so results are the same bytes on any number of threads. Loops go over pieces of
rows, as in `system_kernels`. Import only after `soft.devices.start_taichi`.

`equation` (H, W, 4) holds a, b and c of a pixel's a u + b v + c = 0, and 1 where it may be used, else 0.
"""

import taichi as ti

from soft.flow.black_anandan.system_kernels import PIECE, pieces
from soft.flow.spline_kernels import inside

Picture = ti.types.ndarray(ti.f32, ndim=2)
Channels = ti.types.ndarray(ti.f32, ndim=3)


@ti.func
def penalty_weight(z, precision, convex):
    """Slope of a penalty at z, over z; its `precision` is 1 / sigma^2.

    The quadratic z^2 / 2 sigma^2 has the share `convex`, the Lorentzian (the paper's Eq. 5) the rest.
    """
    return (convex + (1 - convex) / (1 + z * z * precision / 2)) * precision


@ti.func
def weigh_pixel(
    equation: ti.template(), linked: ti.template(), flow: ti.template(), row, column, convex, data_precision,
    step_precision, smoothness, hold, tensor: ti.template(), links: ti.template(), right: ti.template(),
):  # fmt: skip
    """Fill in a pixel's data, and its links to the right and to below."""
    y, x = row + 1, column + 1
    a, b = equation[row, column, 0], equation[row, column, 1]
    residual = a * flow[row, column, 0] + b * flow[row, column, 1] + equation[row, column, 2]
    weight = equation[row, column, 3] * penalty_weight(residual, data_precision, convex)
    tensor[y, x, 0], tensor[y, x, 2] = weight * a * a + hold, weight * b * b + hold
    tensor[y, x, 1] = weight * a * b
    right[y, x, 0], right[y, x, 1] = -weight * a * residual, -weight * b * residual
    beside, below = ti.min(column + 1, linked.shape[1] - 1), ti.min(row + 1, linked.shape[0] - 1)
    here = smoothness * linked[row, column]
    to_right = here * linked[row, beside] * (beside > column)
    to_below = here * linked[below, column] * (below > row)
    for k in ti.static(range(2)):
        step = flow[row, beside, k] - flow[row, column, k]
        links[y, x, k] = to_right * penalty_weight(step, step_precision, convex)
        step = flow[below, column, k] - flow[row, column, k]
        links[y, x, 2 + k] = to_below * penalty_weight(step, step_precision, convex)


@ti.kernel
def linearize(first: Channels, warped: Channels, usable: Picture, flow: Channels, equation: Channels):
    """Brightness constancy around the present flow (the paper's Eq. 3).

    Slopes are the mean of both pictures'. A pixel that has gone out of sight is of no use.
    """
    height, width = usable.shape[0], usable.shape[1]
    for piece in range(height * pieces(width)):
        row, start = piece // pieces(width), piece % pieces(width) * PIECE
        for column in range(start, ti.min(start + PIECE, width)):
            u, v = flow[row, column, 0], flow[row, column, 1]
            a = (first[row, column, 1] + warped[row, column, 1]) / 2
            b = (first[row, column, 2] + warped[row, column, 2]) / 2
            equation[row, column, 0], equation[row, column, 1] = a, b
            equation[row, column, 2] = warped[row, column, 0] - first[row, column, 0] - a * u - b * v
            there = inside(column + u, row + v, height, width)
            equation[row, column, 3] = usable[row, column] * there


@ti.kernel
def weigh(
    equation: Channels,
    linked: Picture,
    flow: Channels,
    convex: ti.f32,
    data_width: ti.f32,
    step_width: ti.f32,
    smoothness: ti.f32,
    hold: ti.f32,
    tensor: Channels,
    links: Channels,
    right: Channels,
):
    """Linear equations for the change of flow that lowers the energy (iteratively reweighted least squares).

    `right` is minus the energy's slope. `hold` ties the change to zero, ever so slightly, where nothing else
    does. The last three have a rim, one line before the pixels (`system_kernels`).
    """
    height, width = flow.shape[0], flow.shape[1]
    data_precision, step_precision = 1 / data_width**2, 1 / step_width**2
    for piece in range(height * pieces(width)):
        row, first = piece // pieces(width), piece % pieces(width) * PIECE
        for column in range(first, ti.min(first + PIECE, width)):
            weigh_pixel(
                equation, linked, flow, row, column, convex, data_precision, step_precision,
                smoothness, hold, tensor, links, right,
            )  # fmt: skip
    for piece in range(height * pieces(width)):
        row, first = piece // pieces(width), piece % pieces(width) * PIECE
        for column in range(first, ti.min(first + PIECE, width)):
            y, x = row + 1, column + 1
            left, above = ti.max(column - 1, 0), ti.max(row - 1, 0)
            beside, below = ti.min(column + 1, width - 1), ti.min(row + 1, height - 1)
            for k in ti.static(range(2)):
                # Beyond the picture links are zero.
                here = flow[row, column, k]
                pull = links[y, x - 1, k] * (flow[row, left, k] - here)
                pull += links[y, x, k] * (flow[row, beside, k] - here)
                pull += links[y - 1, x, 2 + k] * (flow[above, column, k] - here)
                pull += links[y, x, 2 + k] * (flow[below, column, k] - here)
                right[y, x, k] += pull
