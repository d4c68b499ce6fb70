"""Kernels: the energy's equations, weighted by the slopes of its penalties.

Every number has one writer, so results are the same bytes on any number of threads. Loops over pixels are
flat (`ti.ndrange`): taichi shares a loop over some hundred rows between no threads. Import only after
`soft.devices.start_taichi`.

`equation` (H, W, 4) holds a, b and c of a pixel's a u + b v + c = 0, and 1 where it may be used, else 0.
"""

import taichi as ti

from soft.flow.spline_kernels import inside

Picture = ti.types.ndarray(ti.f32, ndim=2)
Channels = ti.types.ndarray(ti.f32, ndim=3)


@ti.func
def penalty_weight(z, sigma, convex):
    """Slope of a penalty at z, over z.

    The quadratic z^2 / 2 sigma^2 has the share `convex`, the Lorentzian (the paper's Eq. 5) the rest.
    """
    return (convex + (1 - convex) / (1 + z * z / (2 * sigma * sigma))) / (sigma * sigma)


@ti.kernel
def linearize(first: Channels, warped: Channels, usable: Picture, flow: Channels, equation: Channels):
    """Brightness constancy around the present flow (the paper's Eq. 3).

    Slopes are the mean of both pictures'. A pixel that has gone out of sight is of no use.
    """
    for row, column in ti.ndrange(usable.shape[0], usable.shape[1]):
        u, v = flow[row, column, 0], flow[row, column, 1]
        a = (first[row, column, 1] + warped[row, column, 1]) / 2
        b = (first[row, column, 2] + warped[row, column, 2]) / 2
        equation[row, column, 0], equation[row, column, 1] = a, b
        equation[row, column, 2] = warped[row, column, 0] - first[row, column, 0] - a * u - b * v
        there = inside(column + u, row + v, usable.shape[0], usable.shape[1])
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
    for row, column in ti.ndrange(height, width):
        y, x = row + 1, column + 1
        a, b = equation[row, column, 0], equation[row, column, 1]
        residual = a * flow[row, column, 0] + b * flow[row, column, 1] + equation[row, column, 2]
        weight = equation[row, column, 3] * penalty_weight(residual, data_width, convex)
        tensor[y, x, 0], tensor[y, x, 2] = weight * a * a + hold, weight * b * b + hold
        tensor[y, x, 1] = weight * a * b
        right[y, x, 0], right[y, x, 1] = -weight * a * residual, -weight * b * residual
        for k in ti.static(range(2)):
            here, to_right, to_below = flow[row, column, k], ti.f32(0.0), ti.f32(0.0)
            if column + 1 < width:
                step = flow[row, column + 1, k] - here
                to_right = linked[row, column + 1] * smoothness * penalty_weight(step, step_width, convex)
            if row + 1 < height:
                step = flow[row + 1, column, k] - here
                to_below = linked[row + 1, column] * smoothness * penalty_weight(step, step_width, convex)
            links[y, x, k], links[y, x, 2 + k] = (
                linked[row, column] * to_right,
                linked[row, column] * to_below,
            )
    for row, column in ti.ndrange(height, width):
        y, x = row + 1, column + 1
        for k in ti.static(range(2)):
            here, pull = flow[row, column, k], ti.f32(0.0)
            if column > 0:
                pull += links[y, x - 1, k] * (flow[row, column - 1, k] - here)
            if column + 1 < width:
                pull += links[y, x, k] * (flow[row, column + 1, k] - here)
            if row > 0:
                pull += links[y - 1, x, 2 + k] * (flow[row - 1, column, k] - here)
            if row + 1 < height:
                pull += links[y, x, 2 + k] * (flow[row + 1, column, k] - here)
            right[y, x, k] += pull
