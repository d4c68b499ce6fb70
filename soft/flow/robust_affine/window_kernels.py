"""Kernels: affine fits to brightness constraints in Gaussian windows.

A model of motion is (u, ux, uy, v, vx, vy): motion at a place, px, and its gradient,
px/px (the paper's Eq. 4).

Every number has one writer, so results are the same bytes on any number of threads. Loops over pixels are
flat (`ti.ndrange`): taichi shares a loop over some hundred rows between no threads. Import only after
`soft.devices.start_taichi`.
"""

import taichi as ti

Channels = ti.types.ndarray(ti.f32, ndim=3)
Table = ti.types.ndarray(ti.f32, ndim=2)
Levels = ti.types.ndarray(ti.i32, ndim=2)
Flags = ti.types.ndarray(ti.u8, ndim=2)


@ti.func
def pull_share(z):
    """How much of noise's pull a Lorentzian weight lets through, over the weight, at a residual of z widths.

    The derivative of the weighted residual: what its product with a slope is on average for Gaussian noise
    (Stein's lemma).
    """
    return (1 - z * z / 2) / (1 + z * z / 2)


@ti.kernel
def multiply(
    constraint: Channels,
    noise: ti.f32,
    width: ti.f32,
    stretch: ti.f32,
    rest: ti.i32,
    squares: Channels,
    targets: Channels,
):
    """What windows sum: jx jx, jx jy, jy jy and jx d, jy d, each times its pixel's weight.

    Weights are Lorentzian, `width` in `noise`, which is in grey levels (the paper's Eq. 5). Targets are freed
    of noise's pull, which is stretched as residuals are in d. With `rest` 1, d is what the present motion
    leaves unexplained.
    """
    for row, column in ti.ndrange(constraint.shape[0], constraint.shape[1]):
        residual = constraint[row, column, 4]
        z = residual / (width * noise)
        weight = constraint[row, column, 3] / (1 + z * z / 2)
        jx, jy = constraint[row, column, 0], constraint[row, column, 1]
        d = ti.select(rest == 1, -residual, constraint[row, column, 2])
        squares[row, column, 0] = weight * jx * jx
        squares[row, column, 1] = weight * jx * jy
        squares[row, column, 2] = weight * jy * jy
        free = weight * pull_share(z) * noise * noise * ti.select(rest == 1, 1, stretch)
        targets[row, column, 0] = weight * jx * d + free * constraint[row, column, 5]
        targets[row, column, 1] = weight * jy * d + free * constraint[row, column, 6]


@ti.kernel
def gather(products: Channels, gathered: Channels):
    """Sums of 1/4, 1/2, 1/4 each way around every second place."""
    height, width = products.shape[0], products.shape[1]
    for row, column in ti.ndrange(gathered.shape[0], gathered.shape[1]):
        whole = row > 0 and column > 0 and 2 * row + 1 < height and 2 * column + 1 < width
        for channel in range(gathered.shape[2]):
            total = ti.cast(0, ti.f32)
            for j, i in ti.static(ti.ndrange((-1, 2), (-1, 2))):
                r, c = 2 * row + j, 2 * column + i
                if whole or (r >= 0 and c >= 0 and r < height and c < width):
                    total += ti.static((2 - abs(j)) * (2 - abs(i)) / 16) * products[r, c, channel]
            gathered[row, column, channel] = total


@ti.dataclass
class Cell:
    """The places between four nodes, of which the upper left one names it.

    Beyond the last nodes there are none: these stand for them. `models` are the corners', row by row; `apart`
    tells whether the lower ones are further down than the upper ones, and the right ones further right, 1 or
    0 each. Its places are `top` to `bottom`, `left` to `right`, the last of each left out.
    """

    models: ti.types.matrix(4, 6, ti.f32)
    apart: ti.types.vector(2, ti.i32)
    top: ti.i32
    bottom: ti.i32
    left: ti.i32
    right: ti.i32


@ti.func
def cell_at(at_nodes: ti.template(), line, node, stride, places: ti.template()):
    """The cell of a node in a grid of `places`, nodes `stride` of them apart."""
    last_line, last_node = at_nodes.shape[0] - 1, at_nodes.shape[1] - 1
    models = ti.Matrix.zero(ti.f32, 4, 6)
    for j, i in ti.static(ti.ndrange(2, 2)):
        for k in ti.static(range(6)):
            models[2 * j + i, k] = at_nodes[ti.min(line + j, last_line), ti.min(node + i, last_node), k]
    return Cell(
        models=models,
        apart=ti.Vector([ti.min(line + 1, last_line) - line, ti.min(node + 1, last_node) - node]),
        top=line * stride,
        bottom=ti.min((line + 1) * stride, places.shape[0]),
        left=node * stride,
        right=ti.min((node + 1) * stride, places.shape[1]),
    )


@ti.func
def blended(cell, stride, row, column, step):
    """Model of a place in a cell: its corners', carried to it and blended. Places are `step` px apart."""
    down, across = row - cell.top, column - cell.left
    fx, fy = ti.cast(across, ti.f32) / stride, ti.cast(down, ti.f32) / stride
    model = ti.Vector.zero(ti.f32, 6)
    for j, i in ti.static(ti.ndrange(2, 2)):
        share = (fx if ti.static(i == 1) else 1 - fx) * (fy if ti.static(j == 1) else 1 - fy)
        x = ti.cast((across - i * cell.apart[1] * stride) * step, ti.f32)
        y = ti.cast((down - j * cell.apart[0] * stride) * step, ti.f32)
        for k in ti.static((0, 3)):
            ux, uy = cell.models[2 * j + i, k + 1], cell.models[2 * j + i, k + 2]
            model[k] += share * (cell.models[2 * j + i, k] + ux * x + uy * y)
            model[k + 1] += share * ux
            model[k + 2] += share * uy
    return model


@ti.kernel
def subtract(
    squares: Channels, targets: Channels, at_nodes: Channels, stride: ti.i32, step: ti.i32, rest: Channels
):
    """`targets` of what is left to explain once places have moved by the models told at nodes."""
    for line, node in ti.ndrange(at_nodes.shape[0], at_nodes.shape[1]):
        cell = cell_at(at_nodes, line, node, stride, squares)
        for row in range(cell.top, cell.bottom):
            for column in range(cell.left, cell.right):
                model = blended(cell, stride, row, column, step)
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
def normal_matrix(sums):
    """Matrix of the normal equations: sums of jx jx, jx jy and jy jy, times 1, x, y, xx, xy, yy each."""
    order = ti.static(((0, 1, 2), (1, 3, 4), (2, 4, 5)))
    return ti.Matrix(
        [
            [sums[6 * (i // 3 + k // 3) + order[i % 3][k % 3]] for k in ti.static(range(6))]
            for i in ti.static(range(6))
        ]
    )


@ti.func
def solved(matrix, right):
    """Solution of six equations, the matrix symmetric and positive; its upper half is not read.

    Factors L D L^T (Golub and Van Loan, Matrix Computations, 4.1.2): L takes the lower half's place.
    """
    x = right
    for k in ti.static(range(6)):
        pivot = 1 / matrix[k, k]
        for i in ti.static(range(k + 1, 6)):
            factor = matrix[i, k] * pivot
            for j in ti.static(range(i, 6)):
                matrix[j, i] -= factor * matrix[j, k]
            x[i] -= factor * x[k]
        x[k] *= pivot
        for i in ti.static(range(k + 1, 6)):
            matrix[i, k] *= pivot
    for k in ti.static((4, 3, 2, 1, 0)):
        for j in ti.static(range(k + 1, 6)):
            x[k] -= matrix[j, k] * x[j]
    return x


@ti.kernel
def solve_nodes(moments: Channels, rights: Channels, scale: ti.f32, held: Channels, models: Channels):
    """Solve every node's normal equations; offsets count in units of `scale` px.

    Each unknown is held, as by one square grey level, at the motion that `held` tells there and at no
    gradient: what texture does not tell stays.
    """
    for line, node in ti.ndrange(models.shape[0], models.shape[1]):
        sums = ti.Vector.zero(ti.f64, 18)
        for k in ti.static(range(18)):
            sums[k] = moments[line, node, k]
        m = normal_matrix(sums)
        b = ti.Vector.zero(ti.f64, 6)
        for i in ti.static(range(6)):
            hold = 1 + m[i, i] / 1000
            m[i, i] += hold
            b[i] = rights[line, node, i]
            if ti.static(i % 3 == 0):
                b[i] += hold * held[line, node, i]
        found = solved(m, b)
        for i in ti.static(range(6)):
            models[line, node, i] = found[i] / (1 if ti.static(i % 3 == 0) else scale)


@ti.kernel
def tell_variance(moments: Channels, each: ti.f64, variance: Channels):
    """`each` times the inverse of every node's mean of the slopes' squares: of u and of v; at most 1e6."""
    for line, node in ti.ndrange(variance.shape[0], variance.shape[1]):
        xx = ti.cast(moments[line, node, 0], ti.f64)
        xy = ti.cast(moments[line, node, 6], ti.f64)
        yy = ti.cast(moments[line, node, 12], ti.f64)
        share = each / ti.max(xx * yy - xy * xy, 1e-6)
        variance[line, node, 0] = ti.min(yy * share, 1e6)
        variance[line, node, 1] = ti.min(xx * share, 1e6)


@ti.kernel
def tell(models: Channels, displacement: Channels, gradient: Channels):
    """Models taken apart: u, v, and d(u, v)_i / d(x, y)_j at 2 i + j."""
    for row, column in ti.ndrange(models.shape[0], models.shape[1]):
        for i in ti.static(range(2)):
            displacement[row, column, i] = models[row, column, 3 * i]
            for j in ti.static(range(2)):
                gradient[row, column, 2 * i + j] = models[row, column, 3 * i + 1 + j]


@ti.kernel
def tell_spread(at_nodes: Channels, stride: ti.i32, displacement: Channels, gradient: Channels):
    """The same, from models told at nodes `stride` px apart."""
    for line, node in ti.ndrange(at_nodes.shape[0], at_nodes.shape[1]):
        cell = cell_at(at_nodes, line, node, stride, displacement)
        for row in range(cell.top, cell.bottom):
            for column in range(cell.left, cell.right):
                model = blended(cell, stride, row, column, 1)
                for i in ti.static(range(2)):
                    displacement[row, column, i] = model[3 * i]
                    for j in ti.static(range(2)):
                        gradient[row, column, 2 * i + j] = model[3 * i + 1 + j]


@ti.kernel
def spread(at_nodes: Channels, stride: ti.i32, step: ti.i32, models: Channels):
    """Every place's model from those told at nodes."""
    for line, node in ti.ndrange(at_nodes.shape[0], at_nodes.shape[1]):
        cell = cell_at(at_nodes, line, node, stride, models)
        for row in range(cell.top, cell.bottom):
            for column in range(cell.left, cell.right):
                model = blended(cell, stride, row, column, step)
                for k in ti.static(range(6)):
                    models[row, column, k] = model[k]


@ti.kernel
def add_spread(at_nodes: Channels, stride: ti.i32, where: Flags, models: Channels):
    """Add every pixel's model from those told at nodes, where that is wanted."""
    for line, node in ti.ndrange(at_nodes.shape[0], at_nodes.shape[1]):
        cell = cell_at(at_nodes, line, node, stride, models)
        for row in range(cell.top, cell.bottom):
            for column in range(cell.left, cell.right):
                if where[row, column] > 0:
                    model = blended(cell, stride, row, column, 1)
                    for k in ti.static(range(6)):
                        models[row, column, k] += model[k]


@ti.kernel
def take_agreeing(
    at_nodes: Channels,
    variance: Channels,
    bearable: Flags,
    stride: ti.i32,
    step: ti.i32,
    confidence: ti.f32,
    level: ti.i32,
    intervals: Channels,
    motions: Channels,
    best: Channels,
    best_variance: Channels,
    excess: Channels,
    levels: Levels,
):
    """Narrow every pixel's intervals of u and v; take the models of this level while they are not empty.

    A pixel has agreed so far if its level is `level` - 1. `intervals` (H, W, 4) holds lower and upper ends;
    `motions` (H, W, 2) comes out as this level's u and v, `excess` as the square of what the level before
    found otherwise, less half of what noise alone makes of it if both see the same. Models, variances and
    whether they are bearable at all are told at nodes.
    """
    lines, nodes = variance.shape[0], variance.shape[1]
    for line, node in ti.ndrange(at_nodes.shape[0], at_nodes.shape[1]):
        cell = cell_at(at_nodes, line, node, stride, levels)
        for row in range(cell.top, cell.bottom):
            for column in range(cell.left, cell.right):
                model = blended(cell, stride, row, column, step)
                for k in ti.static(range(2)):
                    motions[row, column, k] = model[3 * k]
                if levels[row, column] == level - 1:
                    nearest_line = ti.min((row + stride // 2) // stride, lines - 1)
                    nearest_node = ti.min((column + stride // 2) // stride, nodes - 1)
                    met = ti.cast(bearable[nearest_line, nearest_node], ti.i32)
                    for k in ti.static(range(2)):
                        half = confidence * ti.sqrt(variance[nearest_line, nearest_node, k])
                        low = ti.max(intervals[row, column, 2 * k], model[3 * k] - half)
                        high = ti.min(intervals[row, column, 2 * k + 1], model[3 * k] + half)
                        intervals[row, column, 2 * k], intervals[row, column, 2 * k + 1] = low, high
                        if low > high:
                            met = 0
                    if met == 1:
                        levels[row, column] = level
                        for k in ti.static(range(2)):
                            if level > 0:
                                other = model[3 * k] - best[row, column, 3 * k]
                                by_noise = ti.max(
                                    0, best_variance[row, column, k] - variance[nearest_line, nearest_node, k]
                                )
                                excess[row, column, k] = other * other - by_noise / 2
                            best_variance[row, column, k] = variance[nearest_line, nearest_node, k]
                        for k in ti.static(range(6)):
                            best[row, column, k] = model[k]
