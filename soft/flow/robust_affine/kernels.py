"""The kernels: pictures between their pixels, and affine fits to brightness constraints.

Every number has one writer, so results are the same bytes on any number of threads. Import only after
`soft.devices.start_taichi`. A model of motion is (u, ux, uy, v, vx, vy): motion at a place, px, and its
gradient, px/px (the paper's Eq. 4).
"""

import taichi as ti

Picture = ti.types.ndarray(ti.f32, ndim=2)
Channels = ti.types.ndarray(ti.f32, ndim=3)
Places = ti.types.ndarray(ti.i32, ndim=2)
Table = ti.types.ndarray(ti.f32, ndim=2)
Levels = ti.types.ndarray(ti.i32, ndim=2)


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
    first: Channels, warped: Channels, gain: Channels, models: Channels, usable: Picture, constraint: Channels
):
    """Linear brightness constraints at every pixel's present motion: jx, jy, d, weight, residual.

    `first` holds grey level and slopes; `gain` factor and offset that bring the second picture to its light.
    """
    for row, column in ti.ndrange(usable.shape[0], usable.shape[1]):
        there = ti.Vector([warped[row, column, 0], warped[row, column, 1], warped[row, column, 2]])
        u, v = models[row, column, 0], models[row, column, 3]
        found = equation(first, gain, there, u, v, row, column)
        for k in ti.static(range(3)):
            constraint[row, column, k] = found[k]
        constraint[row, column, 3] = usable[row, column] * warped[row, column, 3]
        constraint[row, column, 4] = found[3]


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


@ti.kernel
def multiply(constraint: Channels, width: ti.f32, rest: ti.i32, squares: Channels, targets: Channels):
    """What windows sum: jx jx, jx jy, jy jy and jx d, jy d, each times its pixel's weight.

    Weights are Lorentzian, `width` in grey levels (the paper's Eq. 5). With `rest` 1, d is what the present
    motion leaves unexplained.
    """
    for row, column in ti.ndrange(constraint.shape[0], constraint.shape[1]):
        residual = constraint[row, column, 4]
        z = residual / width
        weight = constraint[row, column, 3] / (1 + z * z / 2)
        jx, jy = constraint[row, column, 0], constraint[row, column, 1]
        d = ti.select(rest == 1, -residual, constraint[row, column, 2])
        squares[row, column, 0] = weight * jx * jx
        squares[row, column, 1] = weight * jx * jy
        squares[row, column, 2] = weight * jy * jy
        targets[row, column, 0] = weight * jx * d
        targets[row, column, 1] = weight * jy * d


@ti.func
def blended(at_nodes: ti.template(), stride, row, column):
    """A pixel's model: those of the four nodes around it, carried to it and blended."""
    line, node = row // stride, column // stride
    below, beside = ti.min(line + 1, at_nodes.shape[0] - 1), ti.min(node + 1, at_nodes.shape[1] - 1)
    fx = ti.cast(column - node * stride, ti.f32) / stride
    fy = ti.cast(row - line * stride, ti.f32) / stride
    model = ti.Vector.zero(ti.f32, 6)
    for j, i in ti.static(ti.ndrange(2, 2)):
        r, n = (below if ti.static(j == 1) else line), (beside if ti.static(i == 1) else node)
        share = (fx if ti.static(i == 1) else 1 - fx) * (fy if ti.static(j == 1) else 1 - fy)
        x, y = ti.cast(column - n * stride, ti.f32), ti.cast(row - r * stride, ti.f32)
        for k in ti.static((0, 3)):
            ux, uy = at_nodes[r, n, k + 1], at_nodes[r, n, k + 2]
            model[k] += share * (at_nodes[r, n, k] + ux * x + uy * y)
            model[k + 1] += share * ux
            model[k + 2] += share * uy
    return model


@ti.kernel
def subtract(squares: Channels, targets: Channels, at_nodes: Channels, stride: ti.i32, rest: Channels):
    """`targets` of what is left to explain once pixels have moved by the models told at nodes."""
    for row, column in ti.ndrange(squares.shape[0], squares.shape[1]):
        model = blended(at_nodes, stride, row, column)
        xx, xy, yy = squares[row, column, 0], squares[row, column, 1], squares[row, column, 2]
        rest[row, column, 0] = targets[row, column, 0] - xx * model[0] - xy * model[3]
        rest[row, column, 1] = targets[row, column, 1] - xy * model[0] - yy * model[3]


@ti.kernel
def sum_squares_along_rows(squares: Channels, taps: Table, stride: ti.i32, sums: Channels):
    """Windowed sums along rows at every node's column of three products times 1, t, t^2.

    `taps` (2 R + 1, 3) holds the window's weights times 1, t, t^2.
    """
    width, reach = squares.shape[1], taps.shape[0] // 2
    for row, node in ti.ndrange(sums.shape[0], sums.shape[1]):
        first = node * stride - reach
        total = ti.Vector.zero(ti.f32, 9)
        for column in range(ti.max(0, first), ti.min(width, first + 2 * reach + 1)):
            for c in ti.static(range(3)):
                value = squares[row, column, c]
                for k in ti.static(range(3)):
                    total[3 * c + k] += taps[column - first, k] * value
        for k in ti.static(range(9)):
            sums[row, node, k] = total[k]


@ti.kernel
def sum_targets_along_rows(targets: Channels, taps: Table, stride: ti.i32, sums: Channels):
    """The same of two products times 1, t."""
    width, reach = targets.shape[1], taps.shape[0] // 2
    for row, node in ti.ndrange(sums.shape[0], sums.shape[1]):
        first = node * stride - reach
        total = ti.Vector.zero(ti.f32, 4)
        for column in range(ti.max(0, first), ti.min(width, first + 2 * reach + 1)):
            for c in ti.static(range(2)):
                value = targets[row, column, c]
                for k in ti.static(range(2)):
                    total[2 * c + k] += taps[column - first, k] * value
        for k in ti.static(range(4)):
            sums[row, node, k] = total[k]


@ti.kernel
def sum_squares_along_columns(sums: Channels, taps: Table, stride: ti.i32, moments: Channels):
    """Finish the windows: of each of three products its sums times 1, x, y, xx, xy, yy at every node."""
    height, reach = sums.shape[0], taps.shape[0] // 2
    for line, node in ti.ndrange(moments.shape[0], moments.shape[1]):
        first = line * stride - reach
        total = ti.Vector.zero(ti.f32, 18)
        for row in range(ti.max(0, first), ti.min(height, first + 2 * reach + 1)):
            g, gt, gtt = taps[row - first, 0], taps[row - first, 1], taps[row - first, 2]
            for c in ti.static(range(3)):
                one, x = sums[row, node, 3 * c], sums[row, node, 3 * c + 1]
                total[6 * c] += g * one
                total[6 * c + 1] += g * x
                total[6 * c + 2] += gt * one
                total[6 * c + 3] += g * sums[row, node, 3 * c + 2]
                total[6 * c + 4] += gt * x
                total[6 * c + 5] += gtt * one
        for k in ti.static(range(18)):
            moments[line, node, k] = total[k]


@ti.kernel
def sum_targets_along_columns(sums: Channels, taps: Table, stride: ti.i32, rights: Channels):
    """Finish the windows: of each of two products its sums times 1, x, y at every node."""
    height, reach = sums.shape[0], taps.shape[0] // 2
    for line, node in ti.ndrange(rights.shape[0], rights.shape[1]):
        first = line * stride - reach
        total = ti.Vector.zero(ti.f32, 6)
        for row in range(ti.max(0, first), ti.min(height, first + 2 * reach + 1)):
            g, gt = taps[row - first, 0], taps[row - first, 1]
            for c in ti.static(range(2)):
                one = sums[row, node, 2 * c]
                total[3 * c] += g * one
                total[3 * c + 1] += g * sums[row, node, 2 * c + 1]
                total[3 * c + 2] += gt * one
        for k in ti.static(range(6)):
            rights[line, node, k] = total[k]


@ti.func
def solved(matrix, right):
    """Solution of six equations, the matrix symmetric and positive."""
    x = right
    for k in ti.static(range(6)):
        pivot = 1 / matrix[k, k]
        for i in ti.static(range(k + 1, 6)):
            factor = matrix[i, k] * pivot
            for j in ti.static(range(k, 6)):
                matrix[i, j] -= factor * matrix[k, j]
            x[i] -= factor * x[k]
    for k in ti.static((5, 4, 3, 2, 1, 0)):
        for j in ti.static(range(k + 1, 6)):
            x[k] -= matrix[k, j] * x[j]
        x[k] /= matrix[k, k]
    return x


@ti.kernel
def solve_nodes(
    moments: Channels, rights: Channels, stride: ti.i32, scale: ti.f32, held: Channels, models: Channels
):
    """Solve every node's normal equations; offsets count in units of `scale` px.

    Each unknown is held, as by one square grey level, at the motion that `held` tells there and at no
    gradient: what texture does not tell stays.
    """
    for line, node in ti.ndrange(models.shape[0], models.shape[1]):
        m = ti.Matrix.zero(ti.f64, 6, 6)
        b = ti.Vector.zero(ti.f64, 6)
        for block in ti.static(range(3)):
            k = ti.static(6 * block)
            order = ti.static(((k, k + 1, k + 2), (k + 1, k + 3, k + 4), (k + 2, k + 4, k + 5)))
            for i, j in ti.static(ti.ndrange(3, 3)):
                m[(0, 0, 3)[block] + i, (0, 3, 3)[block] + j] = moments[line, node, order[i][j]]
                if ti.static(block == 1):
                    m[3 + i, j] = moments[line, node, order[i][j]]
        for i in ti.static(range(6)):
            hold = 1 + m[i, i] / 1000
            m[i, i] += hold
            b[i] = rights[line, node, i]
            if ti.static(i % 3 == 0):
                b[i] += hold * held[line * stride, node * stride, i]
        found = solved(m, b)
        for i in ti.static(range(6)):
            models[line, node, i] = found[i] / (1 if ti.static(i % 3 == 0) else scale)


@ti.kernel
def spread(at_nodes: Channels, stride: ti.i32, models: Channels):
    """Every pixel's model from those told at nodes."""
    for row, column in ti.ndrange(models.shape[0], models.shape[1]):
        model = blended(at_nodes, stride, row, column)
        for k in ti.static(range(6)):
            models[row, column, k] = model[k]


@ti.kernel
def take_agreeing(
    at_nodes: Channels,
    variance: Channels,
    stride: ti.i32,
    confidence: ti.f32,
    level: ti.i32,
    intervals: Channels,
    motions: Channels,
    best: Channels,
    best_variance: Channels,
    levels: Levels,
):
    """Narrow every pixel's intervals of u and v; take the models of this level while they are not empty.

    A pixel has agreed so far if its level is `level` - 1. `intervals` (H, W, 4) holds lower and upper ends;
    `motions` (H, W, 2) comes out as this level's u and v. Models and variances are told at nodes.
    """
    lines, nodes = variance.shape[0], variance.shape[1]
    for row, column in ti.ndrange(levels.shape[0], levels.shape[1]):
        model = blended(at_nodes, stride, row, column)
        for k in ti.static(range(2)):
            motions[row, column, k] = model[3 * k]
        if levels[row, column] == level - 1:
            line = ti.min((row + stride // 2) // stride, lines - 1)
            node = ti.min((column + stride // 2) // stride, nodes - 1)
            met = 1
            for k in ti.static(range(2)):
                half = confidence * ti.sqrt(variance[line, node, k])
                low = ti.max(intervals[row, column, 2 * k], model[3 * k] - half)
                high = ti.min(intervals[row, column, 2 * k + 1], model[3 * k] + half)
                intervals[row, column, 2 * k], intervals[row, column, 2 * k + 1] = low, high
                if low > high:
                    met = 0
            if met == 1:
                levels[row, column] = level
                for k in ti.static(range(2)):
                    best_variance[row, column, k] = variance[line, node, k]
                for k in ti.static(range(6)):
                    best[row, column, k] = model[k]


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
    width: ti.f32,
    models: Channels,
    fitted: Table,
):
    """Affine fits in windows cut where pixels move otherwise.

    An equation's weight falls with its pixel's distance (to nothing at 2.5 `scale`), with how far that
    pixel's own motion is from what the place's model says there (to nothing at 3 `apart`, px), and with its
    residual (Lorentzian of `width` grey levels).
    """
    height, across = constraint.shape[0], constraint.shape[1]
    for place in range(places.shape[0]):
        row, column = places[place, 0], places[place, 1]
        model = ti.Vector.zero(ti.f32, 6)
        for k in ti.static(range(6)):
            model[k] = models[row, column, k] * (1 if ti.static(k % 3 == 0) else scale)
        m = ti.Matrix.zero(ti.f32, 6, 6)
        b = ti.Vector.zero(ti.f32, 6)
        weights = ti.cast(0, ti.f32)
        for r in range(ti.max(0, row - reach), ti.min(height, row + reach + 1)):
            for c in range(ti.max(0, column - reach), ti.min(across, column + reach + 1)):
                x, y = (c - column) / scale, (r - row) / scale
                near = 1 - (x * x + y * y) / 6.25
                u = model[0] + model[1] * x + model[2] * y
                v = model[3] + model[4] * x + model[5] * y
                du, dv = (u - models[r, c, 0]) / apart, (v - models[r, c, 3]) / apart
                alike = 1 - (du * du + dv * dv) / 9
                if near > 0 and alike > 0:
                    jx, jy, d = constraint[r, c, 0], constraint[r, c, 1], constraint[r, c, 2]
                    z = (jx * u + jy * v - d) / width
                    weight = constraint[r, c, 3] * near * near * alike * alike / (1 + z * z / 2)
                    weights += weight
                    j = ti.Vector([jx, jx * x, jx * y, jy, jy * x, jy * y])
                    for i in ti.static(range(6)):
                        b[i] += weight * j[i] * d
                        for k in ti.static(range(i, 6)):
                            m[i, k] += weight * j[i] * j[k]
        for i in ti.static(range(6)):
            hold = 1 + m[i, i] / 500
            m[i, i] += hold
            b[i] += hold * model[i]
            for k in ti.static(range(i)):
                m[i, k] = m[k, i]
        if weights > 3:
            model = solved(m, b)
        for k in ti.static(range(6)):
            fitted[place, k] = model[k] / (1 if ti.static(k % 3 == 0) else scale)
