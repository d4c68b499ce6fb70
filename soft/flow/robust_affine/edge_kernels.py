"""Kernels: models handed on between pixels, and windows cut where pixels move otherwise.

Every number has one writer, so results are the same bytes on any number of threads. Loops over pixels are
flat (`ti.ndrange`): taichi shares a loop over some hundred rows between no threads. Import only after
`soft.devices.start_taichi`.
"""

import taichi as ti

from soft.flow.robust_affine.window_kernels import normal_matrix, solved
from soft.flow.spline_kernels import inside, sample

Picture = ti.types.ndarray(ti.f32, ndim=2)
Channels = ti.types.ndarray(ti.f32, ndim=3)
Places = ti.types.ndarray(ti.i32, ndim=2)
Table = ti.types.ndarray(ti.f32, ndim=2)


@ti.kernel
def tell_costs(places: Places, constraint: Channels, width: ti.f32, cost: Picture):
    """What some places cost as they are: see `try_neighbours`."""
    for place in range(places.shape[0]):
        row, column = places[place, 0], places[place, 1]
        z = constraint[row, column, 4] / width
        seen = constraint[row, column, 3] > 0
        cost[row, column] = ti.select(seen, ti.log(1 + z * z / 2), ti.cast(1.5, ti.f32))


@ti.kernel
def try_neighbours(
    places: Places,
    right: ti.i32,
    down: ti.i32,
    first: Channels,
    coefficients: Picture,
    gain: Channels,
    usable: Picture,
    width: ti.f32,
    models: Channels,
    candidates: Table,
    cost: Picture,
):
    """Model of the pixel at an offset, carried to each place by its own gradient, and what it costs there.

    Cost is the Lorentzian of the residual in grey levels / `width` (the paper's Eq. 5); out of sight, that of
    a residual of 2.6 widths.
    """
    height, across = cost.shape[0], cost.shape[1]
    for place in range(places.shape[0]):
        row, column = places[place, 0], places[place, 1]
        r, n = ti.max(0, ti.min(height - 1, row + down)), ti.max(0, ti.min(across - 1, column + right))
        x, y = ti.cast(column - n, ti.f32), ti.cast(row - r, ti.f32)
        u = models[r, n, 0] + models[r, n, 1] * x + models[r, n, 2] * y
        v = models[r, n, 3] + models[r, n, 4] * x + models[r, n, 5] * y
        grey = sample(coefficients, column + u, row + v)[0]
        z = (gain[row, column, 0] * grey + gain[row, column, 1] - first[row, column, 0]) / width
        here = usable[row, column] * inside(column + u, row + v, height, across)
        cost[row, column] = ti.select(here > 0, ti.log(1 + z * z / 2), ti.cast(1.5, ti.f32))
        candidates[place, 0] = u
        candidates[place, 3] = v
        for k in ti.static((1, 2, 4, 5)):
            candidates[place, k] = models[r, n, k]


@ti.kernel
def take_better(places: Places, candidates: Table, cost: Picture, least: Picture, models: Channels):
    """Each place takes its candidate where that costs less than what it has."""
    for place in range(places.shape[0]):
        row, column = places[place, 0], places[place, 1]
        if cost[row, column] < least[row, column]:
            least[row, column] = cost[row, column]
            for k in ti.static(range(6)):
                models[row, column, k] = candidates[place, k]


@ti.kernel
def refit(
    places: Places,
    constraint: Channels,
    reach: ti.i32,
    scale: ti.f32,
    apart: ti.f32,
    noise: ti.f32,
    width: ti.f32,
    models: Channels,
    fitted: Table,
):
    """Affine fits in windows cut where pixels move otherwise.

    An equation's weight falls with its pixel's distance (to nothing at 2.5 `scale`), with how far that
    pixel's own motion is from what the place's model says there (to nothing at 3 `apart`, px), and with its
    residual (Lorentzian of `width` in `noise`, which is in grey levels).
    """
    height, across = constraint.shape[0], constraint.shape[1]
    for place in range(places.shape[0]):
        row, column = places[place, 0], places[place, 1]
        model = ti.Vector.zero(ti.f32, 6)
        for k in ti.static(range(6)):
            model[k] = models[row, column, k] * (1 if ti.static(k % 3 == 0) else scale)
        squares = ti.Vector.zero(ti.f32, 18)
        b = ti.Vector.zero(ti.f32, 6)
        weights = ti.cast(0, ti.f32)
        per_scale, per_width, per_apart = 1 / scale, 1 / (width * noise), 1 / (3 * apart)
        for r in range(ti.max(0, row - reach), ti.min(height, row + reach + 1)):
            y = (r - row) * per_scale
            for c in range(ti.max(0, column - reach), ti.min(across, column + reach + 1)):
                x = (c - column) * per_scale
                near = 1 - (x * x + y * y) * ti.static(1 / 6.25)
                u = model[0] + model[1] * x + model[2] * y
                v = model[3] + model[4] * x + model[5] * y
                du, dv = (u - models[r, c, 0]) * per_apart, (v - models[r, c, 3]) * per_apart
                alike = 1 - (du * du + dv * dv)
                if near > 0 and alike > 0:
                    jx, jy, d = constraint[r, c, 0], constraint[r, c, 1], constraint[r, c, 2]
                    z = (jx * u + jy * v - d) * per_width
                    lorentzian = 1 / (1 + z * z / 2)
                    weight = constraint[r, c, 3] * near * near * alike * alike * lorentzian
                    weights += weight
                    free = weight * (1 - z * z / 2) * lorentzian * noise * noise
                    right_x = weight * jx * d + free * constraint[r, c, 5]
                    right_y = weight * jy * d + free * constraint[r, c, 6]
                    b += ti.Vector([right_x, right_x * x, right_x * y, right_y, right_y * x, right_y * y])
                    powers = ti.Vector([ti.cast(1, ti.f32), x, y, x * x, x * y, y * y])
                    products = weight * ti.Vector([jx * jx, jx * jy, jy * jy])
                    for i, k in ti.static(ti.ndrange(3, 6)):
                        squares[6 * i + k] += products[i] * powers[k]
        m = normal_matrix(squares)
        for i in ti.static(range(6)):
            hold = 1 + m[i, i] / 500
            m[i, i] += hold
            b[i] += hold * model[i]
        if weights > 3:
            model = solved(m, b)
        for k in ti.static(range(6)):
            fitted[place, k] = model[k] / (1 if ti.static(k % 3 == 0) else scale)
