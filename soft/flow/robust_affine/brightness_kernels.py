"""Kernels: brightness constraints.

Every number has one writer, so results are the same bytes on any number of threads. Loops over pixels are
flat (`ti.ndrange`): taichi shares a loop over some hundred rows between no threads. Import only after
`soft.devices.start_taichi`.
"""

import math

import taichi as ti

from soft.flow.spline_kernels import inside, sample

CUBE = 14 - 6 * math.sqrt(3)

Picture = ti.types.ndarray(ti.f32, ndim=2)
Channels = ti.types.ndarray(ti.f32, ndim=3)
Places = ti.types.ndarray(ti.i32, ndim=2)


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
def equation(first: ti.template(), gain: ti.template(), warped, model_u, model_v, stretch, row, column):
    """jx, jy, d = j . u - stretch r and the residual r of one pixel."""
    factor = gain[row, column, 0]
    residual = factor * warped[0] + gain[row, column, 1] - first[row, column, 0]
    jx = (first[row, column, 1] + factor * warped[1]) / 2
    jy = (first[row, column, 2] + factor * warped[2]) / 2
    return ti.Vector([jx, jy, jx * model_u + jy * model_v - stretch * residual, residual])


@ti.kernel
def constrain(
    first: Channels,
    warped: Channels,
    gain: Channels,
    models: Channels,
    usable: Picture,
    step: ti.i32,
    stretch: ti.f32,
    constraint: Channels,
):
    """Linear brightness constraints at every pixel's present motion: jx, jy, d, weight, residual, pull.

    `pull` is that of noise, two numbers. `first` holds grey level and slopes; `gain` factor and offset that
    bring the second picture to its light; `stretch` meets noise of the slopes.
    """
    for row, column in ti.ndrange(usable.shape[0], usable.shape[1]):
        there = ti.Vector([warped[row, column, 0], warped[row, column, 1], warped[row, column, 2]])
        u, v = models[row, column, 0], models[row, column, 3]
        found = equation(first, gain, there, u, v, stretch, row, column)
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
    stretch: ti.f32,
    constraint: Channels,
):
    """The same at some places only, where pixels have gone elsewhere since."""
    height, width = coefficients.shape[0], coefficients.shape[1]
    for place in range(places.shape[0]):
        row, column = places[place, 0], places[place, 1]
        u, v = models[row, column, 0], models[row, column, 3]
        x, y = column + u, row + v
        found = equation(first, gain, sample(coefficients, x, y), u, v, stretch, row, column)
        for k in ti.static(range(3)):
            constraint[row, column, k] = found[k]
        constraint[row, column, 3] = usable[row, column] * inside(x, y, height, width)
        constraint[row, column, 4] = found[3]
        pull = noise_pull(x, y)
        constraint[row, column, 5], constraint[row, column, 6] = pull[0], pull[1]
