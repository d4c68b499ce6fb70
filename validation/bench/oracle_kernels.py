"""Kernels: affine windows that know the true motion.

A model is (u, ux, uy, v, vx, vy) as in `soft.flow.robust_affine.window_kernels`, about its place. Every
number has one writer. Import only after `soft.devices.start_taichi`.
"""

import taichi as ti

from soft.flow.robust_affine.brightness_kernels import equation, noise_pull
from soft.flow.robust_affine.window_kernels import pull_share, solved
from soft.flow.spline_kernels import inside, sample

Picture = ti.types.ndarray(ti.f32, ndim=2)
Channels = ti.types.ndarray(ti.f32, ndim=3)
Places = ti.types.ndarray(ti.i32, ndim=2)
Table = ti.types.ndarray(ti.f32, ndim=2)
Numbers = ti.types.ndarray(ti.f32, ndim=1)

LEAST = 8
"""Pixels that a window must hold."""
_CORE = 3
"""Reach of the pixels that the gradient at a place is first taken from, px."""
_ALIKE = 0.3
"""Width of the Lorentzian, in px of motion, that weighs them."""


@ti.func
def gradient_around(motion: ti.template(), known: ti.template(), row, column):
    """Gradient of the true motion at a place by those of its neighbours that move much as it does."""
    height, width = known.shape[0], known.shape[1]
    xx, xy, yy = ti.cast(1e-3, ti.f32), ti.cast(0, ti.f32), ti.cast(1e-3, ti.f32)
    rights = ti.Vector.zero(ti.f32, 4)
    for r in range(ti.max(0, row - _CORE), ti.min(height, row + _CORE + 1)):
        for c in range(ti.max(0, column - _CORE), ti.min(width, column + _CORE + 1)):
            x, y = ti.cast(c - column, ti.f32), ti.cast(r - row, ti.f32)
            if known[r, c] > 0 and x * x + y * y <= _CORE * _CORE:
                du = motion[r, c, 0] - motion[row, column, 0]
                dv = motion[r, c, 1] - motion[row, column, 1]
                weight = 1 / (1 + (du * du + dv * dv) / (_ALIKE * _ALIKE))
                xx, xy, yy = xx + weight * x * x, xy + weight * x * y, yy + weight * y * y
                rights += weight * ti.Vector([x * du, y * du, x * dv, y * dv])
    determinant = xx * yy - xy * xy
    return (
        ti.Vector(
            [
                yy * rights[0] - xy * rights[1],
                xx * rights[1] - xy * rights[0],
                yy * rights[2] - xy * rights[3],
                xx * rights[3] - xy * rights[2],
            ]
        )
        / determinant
    )


@ti.func
def moved(model, x, y):
    """Motion that a model tells at an offset from its place."""
    return ti.Vector([model[0] + model[1] * x + model[2] * y, model[3] + model[4] * x + model[5] * y])


@ti.func
def belongs(motion: ti.template(), known: ti.template(), model, tolerance, radius, row, column, r, c):
    """Whether a pixel lies within `radius` of a place and truly moves as the place's model says."""
    x, y = ti.cast(c - column, ti.f32), ti.cast(r - row, ti.f32)
    there = moved(model, x, y)
    du, dv = there[0] - motion[r, c, 0], there[1] - motion[r, c, 1]
    near = x * x + y * y <= radius * radius
    return known[r, c] > 0 and near and du * du + dv * dv <= tolerance * tolerance


@ti.func
def spread_out(jx, jy, x, y):
    """How an equation depends on the six unknowns."""
    return ti.Vector([jx, jx * x, jx * y, jy, jy * x, jy * y])


@ti.func
def completed(upper):
    """A symmetric matrix from its upper half, held a very little: singular ones stay solvable."""
    m = upper
    for i in ti.static(range(6)):
        m[i, i] += 1e-3 + 1e-6 * m[i, i]
        for k in ti.static(range(i)):
            m[i, k] = m[k, i]
    return m


@ti.func
def fit_to_truth(
    constraint: ti.template(),
    motion: ti.template(),
    known: ti.template(),
    member,
    tolerance,
    radius,
    noise,
    width,
    row,
    column,
):
    """Normal equations of a window for its true motion: matrix, right side, pixels, mean squared residual.

    Offsets count in units of `radius`. The mean is that of the residuals at the true motion, weighted.
    """
    height, across, reach = known.shape[0], known.shape[1], ti.cast(radius, ti.i32)
    m = ti.Matrix.zero(ti.f64, 6, 6)
    b = ti.Vector.zero(ti.f64, 6)
    count, weights, squares = 0, ti.cast(0, ti.f32), ti.cast(0, ti.f32)
    for r in range(ti.max(0, row - reach), ti.min(height, row + reach + 1)):
        for c in range(ti.max(0, column - reach), ti.min(across, column + reach + 1)):
            if belongs(motion, known, member, tolerance, radius, row, column, r, c):
                jx, jy, residual = constraint[r, c, 0], constraint[r, c, 1], constraint[r, c, 4]
                z = residual / (width * noise)
                weight = constraint[r, c, 3] / (1 + z * z / 2)
                count += ti.cast(weight > 0, ti.i32)
                weights += weight
                squares += weight * residual * residual
                j = spread_out(jx, jy, (c - column) / radius, (r - row) / radius)
                told = jx * motion[r, c, 0] + jy * motion[r, c, 1]
                for i in ti.static(range(6)):
                    b[i] += weight * j[i] * told
                    for k in ti.static(range(i, 6)):
                        m[i, k] += weight * j[i] * j[k]
    return completed(m), b, count, squares / ti.max(weights, 1e-6)


@ti.func
def middle_variance(m):
    """Variance of u plus that of v at a window's place, for equations of variance 1."""
    total = ti.cast(0, ti.f64)
    for which in range(2):
        unit = ti.Vector.zero(ti.f64, 6)
        for i in ti.static(range(6)):
            unit[i] = ti.cast(i == 3 * which, ti.f64)
        column = solved(m, unit)
        total += column[0] if which == 0 else column[3]
    return total


@ti.kernel
def choose_windows(
    places: Places,
    constraint: Channels,
    motion: Channels,
    known: Picture,
    radii: Numbers,
    tolerances: Numbers,
    noise: ti.f32,
    width: ti.f32,
    members: Table,
    chosen: Table,
):
    """For every place the window whose error is expected to be least.

    `constraint` holds the equations at the true motion. Expected is: the square of what the noise-free fit to
    the true motion is off at the place, plus the variance of u and v by the residuals at the true motion.
    `members` (P, 6) come out as the models that tell a window's members, `chosen` (P, 3) as the expected
    square, radius and tolerance; where no window holds `LEAST` pixels, infinite, 0 and 0.
    """
    for place in range(places.shape[0]):
        row, column = places[place, 0], places[place, 1]
        u, v = motion[row, column, 0], motion[row, column, 1]
        slope = gradient_around(motion, known, row, column)
        chosen[place, 0], chosen[place, 1], chosen[place, 2] = ti.math.inf, 0, 0
        for which in range(tolerances.shape[0]):
            tolerance = tolerances[which]
            member = ti.Vector([u, slope[0], slope[1], v, slope[2], slope[3]])
            for size in range(radii.shape[0]):
                radius = radii[size]
                m, b, count, square = fit_to_truth(
                    constraint, motion, known, member, tolerance, radius, noise, width, row, column
                )
                if count >= LEAST:
                    found = solved(m, b)
                    off = (found[0] - u) ** 2 + (found[3] - v) ** 2
                    expected = off + middle_variance(m) * ti.max(noise * noise, square)
                    if expected < chosen[place, 0]:
                        chosen[place, 0], chosen[place, 1], chosen[place, 2] = expected, radius, tolerance
                        for k in ti.static(range(6)):
                            members[place, k] = member[k]
                    if off <= tolerance * tolerance:  # the next size's members go on from here
                        for k in ti.static(range(6)):
                            member[k] = found[k] / (1 if ti.static(k % 3 == 0) else radius)


@ti.func
def step_in_window(
    constraint: ti.template(),
    first: ti.template(),
    coefficients: ti.template(),
    gain: ti.template(),
    motion: ti.template(),
    known: ti.template(),
    member,
    model,
    tolerance,
    radius,
    noise,
    width,
    reweigh,
    row,
    column,
):
    """One step of Gauss-Newton, offsets in units of `radius`."""
    height, across, reach = known.shape[0], known.shape[1], ti.cast(radius, ti.i32)
    m = ti.Matrix.zero(ti.f64, 6, 6)
    b = ti.Vector.zero(ti.f64, 6)
    for r in range(ti.max(0, row - reach), ti.min(height, row + reach + 1)):
        for c in range(ti.max(0, column - reach), ti.min(across, column + reach + 1)):
            if belongs(motion, known, member, tolerance, radius, row, column, r, c):
                u, v = moved(model, ti.cast(c - column, ti.f32), ti.cast(r - row, ti.f32))
                found = equation(first, gain, sample(coefficients, c + u, r + v), u, v, 1.0, r, c)
                z = ti.select(reweigh == 1, found[3], constraint[r, c, 4]) / (width * noise)
                weight = inside(c + u, r + v, height, across) / (1 + z * z / 2)
                x, y = (c - column) / radius, (r - row) / radius
                j = spread_out(found[0], found[1], x, y)
                pull = noise_pull(c + u, r + v) * weight * pull_share(z) * noise * noise
                free = spread_out(pull[0], pull[1], x, y)
                for i in ti.static(range(6)):
                    b[i] += free[i] - weight * j[i] * found[3]
                    for k in ti.static(range(i, 6)):
                        m[i, k] += weight * j[i] * j[k]
    return solved(completed(m), b)


@ti.kernel
def measure(
    places: Places,
    constraint: Channels,
    first: Channels,
    coefficients: Picture,
    gain: Channels,
    motion: Channels,
    known: Picture,
    members: Table,
    chosen: Table,
    noise: ti.f32,
    width: ti.f32,
    turns: ti.i32,
    reweigh: ti.i32,
    models: Table,
):
    """Fit an affine motion to the pictures in every place's window, from `models` (P, 6) on, in place.

    In each turn the second picture is read anew where the model takes the window's pixels. Weights are those
    of the residuals at the true motion (`constraint`), or with `reweigh` 1 of the present ones.
    """
    for place in range(places.shape[0]):
        row, column = places[place, 0], places[place, 1]
        radius, tolerance = chosen[place, 1], chosen[place, 2]
        if radius > 0:
            member, model = ti.Vector.zero(ti.f32, 6), ti.Vector.zero(ti.f32, 6)
            for k in ti.static(range(6)):
                member[k], model[k] = members[place, k], models[place, k]
            for _ in range(turns):
                step = step_in_window(
                    constraint, first, coefficients, gain, motion, known, member, model, tolerance, radius,
                    noise, width, reweigh, row, column,
                )  # fmt: skip
                for k in ti.static(range(6)):
                    model[k] += step[k] / (1 if ti.static(k % 3 == 0) else radius)
            for k in ti.static(range(6)):
                models[place, k] = model[k]
