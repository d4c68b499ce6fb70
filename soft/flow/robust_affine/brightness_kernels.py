"""Kernels: pictures between their pixels, and brightness constraints.

Every number has one writer, so results are the same bytes on any number of threads. Loops over pixels are
flat (`ti.ndrange`): taichi shares a loop over some hundred rows between no threads. Import only after
`soft.devices.start_taichi`.
"""

import math

import taichi as ti

CUBE = 14 - 6 * math.sqrt(3)

Picture = ti.types.ndarray(ti.f32, ndim=2)
Channels = ti.types.ndarray(ti.f32, ndim=3)
Places = ti.types.ndarray(ti.i32, ndim=2)


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
def noise_between(t):
    """Variance of white noise in a picture at a share t between two pixels, and its derivative by t.

    Of the cubic spline through pixels whose noise has variance 1: 1 - 3 s^2 - (14 - 6 sqrt 3) s^3 with
    s = t (1 - t), by summing the squares of its weights.
    """
    s = t * (1 - t)
    return ti.Vector([1 - s * s * (3 + CUBE * s), -s * (6 + 3 * CUBE * s) * (1 - 2 * t)])


@ti.func
def noise_pull(x, y):
    """What slope times residual is on average for noise alone, over the residual's variance; for x and y.

    Interpolation smoothes noise most half-way between pixels, so residuals are least there, and fits are
    drawn to it (the noise-induced bias of digital image correlation).
    """
    across, down = noise_between(x - ti.floor(x)), noise_between(y - ti.floor(y))
    both = 4 * (1 + across[0] * down[0])
    return ti.Vector([across[1] * down[0] / both, across[0] * down[1] / both])


@ti.func
def inside(x, y, height, width):
    """1 where (x, y) lies between the outermost pixel centres, else 0."""
    return ti.cast(x >= 0 and y >= 0 and x <= width - 1 and y <= height - 1, ti.f32)


@ti.kernel
def warp(coefficients: Picture, step: ti.i32, models: Channels, warped: Channels):
    """Grey level and slopes of the second picture where each pixel has gone, and whether it is still there.

    Of every `step`-th pixel each way.
    """
    height, width = coefficients.shape[0], coefficients.shape[1]
    for row, column in ti.ndrange(models.shape[0], models.shape[1]):
        x, y = column * step + models[row, column, 0], row * step + models[row, column, 3]
        found = sample(coefficients, x, y)
        for i in ti.static(range(3)):
            warped[row, column, i] = found[i]
        warped[row, column, 3] = inside(x, y, height, width)


@ti.func
def equation(first: ti.template(), gain: ti.template(), warped, model_u, model_v, row, column):
    """jx, jy, d = j . u - r and the residual r of one pixel."""
    factor = gain[row, column, 0]
    residual = factor * warped[0] + gain[row, column, 1] - first[row, column, 0]
    jx = (first[row, column, 1] + factor * warped[1]) / 2
    jy = (first[row, column, 2] + factor * warped[2]) / 2
    return ti.Vector([jx, jy, jx * model_u + jy * model_v - residual, residual])


@ti.kernel
def constrain(
    first: Channels,
    warped: Channels,
    gain: Channels,
    models: Channels,
    usable: Picture,
    step: ti.i32,
    constraint: Channels,
):
    """Linear brightness constraints at every pixel's present motion: jx, jy, d, weight, residual, pull.

    `pull` is that of noise, two numbers. `first` holds grey level and slopes; `gain` factor and offset that
    bring the second picture to its light.
    """
    for row, column in ti.ndrange(usable.shape[0], usable.shape[1]):
        there = ti.Vector([warped[row, column, 0], warped[row, column, 1], warped[row, column, 2]])
        u, v = models[row, column, 0], models[row, column, 3]
        found = equation(first, gain, there, u, v, row, column)
        for k in ti.static(range(3)):
            constraint[row, column, k] = found[k]
        constraint[row, column, 3] = usable[row, column] * warped[row, column, 3]
        constraint[row, column, 4] = found[3]
        pull = noise_pull(column * step + u, row * step + v)
        constraint[row, column, 5], constraint[row, column, 6] = pull[0], pull[1]


@ti.kernel
def constrain_places(
    places: Places,
    coefficients: Picture,
    first: Channels,
    gain: Channels,
    models: Channels,
    usable: Picture,
    constraint: Channels,
):
    """The same at some places only, where pixels have gone elsewhere since."""
    height, width = coefficients.shape[0], coefficients.shape[1]
    for place in range(places.shape[0]):
        row, column = places[place, 0], places[place, 1]
        u, v = models[row, column, 0], models[row, column, 3]
        x, y = column + u, row + v
        found = equation(first, gain, sample(coefficients, x, y), u, v, row, column)
        for k in ti.static(range(3)):
            constraint[row, column, k] = found[k]
        constraint[row, column, 3] = usable[row, column] * inside(x, y, height, width)
        constraint[row, column, 4] = found[3]
        pull = noise_pull(x, y)
        constraint[row, column, 5], constraint[row, column, 6] = pull[0], pull[1]
