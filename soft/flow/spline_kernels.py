"""Kernels: pictures between their pixels, by cubic B-splines.

Loops over pixels are flat (`ti.ndrange`): taichi shares a loop over some hundred rows between no threads.
Import only after `soft.devices.start_taichi`.
"""

import taichi as ti

Picture = ti.types.ndarray(ti.f32, ndim=2)
Channels = ti.types.ndarray(ti.f32, ndim=3)


@ti.func
def spline_weights(t):
    """Weights of a cubic B-spline's four coefficients around a point at share t between two of them."""
    s = 1 - t
    return ti.Vector(
        [
            s * s * s / 6,
            (4 - 6 * t * t + 3 * t * t * t) / 6,
            (4 - 6 * s * s + 3 * s * s * s) / 6,
            t * t * t / 6,
        ]
    )


@ti.func
def spline_slopes(t):
    """Derivatives of `spline_weights` by t."""
    s = 1 - t
    return ti.Vector([-s * s / 2, (3 * t * t - 4 * t) / 2, (4 * s - 3 * s * s) / 2, t * t / 2])


@ti.func
def mirrored(index, count):
    """Index of the pixel that stands for one a little outside of the picture."""
    index = ti.abs(index)
    if index >= count:
        index = 2 * count - 2 - index
    return ti.max(0, ti.min(count - 1, index))


@ti.func
def sample(coefficients: ti.template(), x, y):
    """Grey level and its slopes at (x, y) px; beyond the picture's border, those on the border."""
    height, width = coefficients.shape[0], coefficients.shape[1]
    x = ti.max(ti.cast(0, ti.f32), ti.min(ti.cast(width - 1, ti.f32), x))
    y = ti.max(ti.cast(0, ti.f32), ti.min(ti.cast(height - 1, ti.f32), y))
    left, top = ti.cast(x, ti.i32), ti.cast(y, ti.i32)
    around = ti.Matrix.zero(ti.f32, 4, 4)
    if left >= 1 and top >= 1 and left <= width - 3 and top <= height - 3:
        for j, i in ti.static(ti.ndrange(4, 4)):
            around[j, i] = coefficients[top + j - 1, left + i - 1]
    else:
        for j, i in ti.static(ti.ndrange(4, 4)):
            around[j, i] = coefficients[mirrored(top + j - 1, height), mirrored(left + i - 1, width)]
    across, slopes_x = spline_weights(x - left), spline_slopes(x - left)
    down, slopes_y = spline_weights(y - top), spline_slopes(y - top)
    lines, slopes = around @ across, around @ slopes_x
    return ti.Vector([down.dot(lines), down.dot(slopes), slopes_y.dot(lines)])


@ti.func
def inside(x, y, height, width):
    """1 where (x, y) lies between the outermost pixel centres, else 0."""
    return ti.cast(x >= 0 and y >= 0 and x <= width - 1 and y <= height - 1, ti.f32)


@ti.kernel
def warp(coefficients: Picture, step: ti.i32, motion: Channels, v: ti.i32, warped: Channels):
    """Grey level and slopes of a picture where each pixel has gone, and whether it is still there.

    Of every `step`-th pixel each way, which goes by channels 0 and `v` of `motion`, px.
    """
    height, width = coefficients.shape[0], coefficients.shape[1]
    for row, column in ti.ndrange(motion.shape[0], motion.shape[1]):
        x, y = column * step + motion[row, column, 0], row * step + motion[row, column, v]
        found = sample(coefficients, x, y)
        for i in ti.static(range(3)):
            warped[row, column, i] = found[i]
        warped[row, column, 3] = inside(x, y, height, width)
