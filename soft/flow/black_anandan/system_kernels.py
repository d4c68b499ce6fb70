"""Kernels: linear equations of a motion field that hold each pixel to its data and to its four neighbours.

At a pixel with motion x (u and v)::

    (tensor + links to its neighbours) x - sum over neighbours of (link * their x) = right-hand side

`tensor` (.., 3) holds uu, uv and vv; `links` (.., 4) those of u and of v to the right, then to below.
`diagonal` (.., 3) is the whole symmetric block at the pixel, `inverse` its inverse, zero where it has none.
All arrays have a rim of zeros around the pixels, one line before and two after: no border is asked for.

Every number has one writer, and sums are taken in one order, so results are the same bytes on any number of
threads. Loops go over pieces of rows: taichi shares a loop over some hundred rows between no threads, and one
over pixels costs it twice as much. Import only after `soft.devices.start_taichi`.
"""

import taichi as ti

Channels = ti.types.ndarray(ti.f32, ndim=3)
Sums = ti.types.ndarray(ti.f64, ndim=1)

PIECE = 64
"""Pixels of a piece of a row."""
BEFORE, AFTER = 1, 2
"""Lines of the rim."""


@ti.func
def pieces(width):
    """Pieces that a row of `width` pixels is cut into."""
    return (width + PIECE - 1) // PIECE


@ti.func
def pair(values: ti.template(), row, column):
    """Both components at a pixel."""
    return ti.Vector([values[row, column, 0], values[row, column, 1]])


@ti.func
def link_total(links: ti.template(), row, column):
    """Sum of a pixel's links, of u and of v."""
    total = ti.Vector([ti.f32(0.0), ti.f32(0.0)])
    for k in ti.static(range(2)):
        total[k] = links[row, column, k] + links[row, column - 1, k]
        total[k] += links[row, column, 2 + k] + links[row - 1, column, 2 + k]
    return total


@ti.func
def pulled(links: ti.template(), motion: ti.template(), row, column):
    """Sum of the neighbours' motions, times their links."""
    pull = ti.Vector([ti.f32(0.0), ti.f32(0.0)])
    for k in ti.static(range(2)):
        pull[k] = links[row, column - 1, k] * motion[row, column - 1, k]
        pull[k] += links[row, column, k] * motion[row, column + 1, k]
        pull[k] += links[row - 1, column, 2 + k] * motion[row - 1, column, k]
        pull[k] += links[row, column, 2 + k] * motion[row + 1, column, k]
    return pull


@ti.func
def block_times(block: ti.template(), row, column, x):
    """A pixel's symmetric block times a vector."""
    u = block[row, column, 0] * x[0] + block[row, column, 1] * x[1]
    v = block[row, column, 1] * x[0] + block[row, column, 2] * x[1]
    return ti.Vector([u, v])


@ti.func
def applied(diagonal: ti.template(), links: ti.template(), motion: ti.template(), row, column):
    """The left-hand side at a pixel."""
    own = block_times(diagonal, row, column, pair(motion, row, column))
    return own - pulled(links, motion, row, column)


@ti.func
def relax(
    inverse: ti.template(),
    links: ti.template(),
    right: ti.template(),
    row,
    first,
    colour,
    motion: ti.template(),
    from_rest: ti.template(),
):
    """Solve the equations of a piece's pixels of one colour for their own motion (Gauss-Seidel).

    `from_rest`: all motion is zero, whatever the array still holds.
    """
    start = first + (row + first + colour) % 2
    end = ti.min(first + PIECE, inverse.shape[1] - AFTER)
    for step in range((end - start + 1) // 2):
        column = start + 2 * step
        total = pair(right, row, column)
        if ti.static(not from_rest):
            total += pulled(links, motion, row, column)
        solved = block_times(inverse, row, column, total)
        motion[row, column, 0], motion[row, column, 1] = solved[0], solved[1]


@ti.kernel
def prepare(tensor: Channels, links: Channels, diagonal: Channels, inverse: Channels):
    """Blocks at the pixels, and their inverses."""
    height, width = tensor.shape[0] - BEFORE - AFTER, tensor.shape[1] - BEFORE - AFTER
    for piece in range(height * pieces(width)):
        row, first = piece // pieces(width) + 1, piece % pieces(width) * PIECE + 1
        for column in range(first, ti.min(first + PIECE, width + 1)):
            total = link_total(links, row, column)
            uu, vv = tensor[row, column, 0] + total[0], tensor[row, column, 2] + total[1]
            uv = tensor[row, column, 1]
            diagonal[row, column, 0], diagonal[row, column, 1], diagonal[row, column, 2] = uu, uv, vv
            determinant, share = uu * vv - uv * uv, ti.f32(0.0)
            if determinant > 0:
                share = 1 / determinant
            inverse[row, column, 0], inverse[row, column, 1] = share * vv, -share * uv
            inverse[row, column, 2] = share * uu


@ti.kernel
def coarsen(tensor: Channels, links: Channels, coarse_tensor: Channels, coarse_links: Channels):
    """Equations of blocks of 2 x 2 pixels that move as one.

    Data add up. Links across a side are halved: two blocks' difference stretches over twice the distance
    (Braess, Computing 55, 1995).
    """
    height, width = coarse_tensor.shape[0] - BEFORE - AFTER, coarse_tensor.shape[1] - BEFORE - AFTER
    for piece in range(height * pieces(width)):
        row, first = piece // pieces(width) + 1, piece % pieces(width) * PIECE + 1
        for column in range(first, ti.min(first + PIECE, width + 1)):
            y, x = 2 * row - 1, 2 * column - 1
            for k in ti.static(range(3)):
                upper = tensor[y, x, k] + tensor[y, x + 1, k]
                coarse_tensor[row, column, k] = upper + tensor[y + 1, x, k] + tensor[y + 1, x + 1, k]
            for k in ti.static(range(2)):
                coarse_links[row, column, k] = (links[y, x + 1, k] + links[y + 1, x + 1, k]) / 2
                coarse_links[row, column, 2 + k] = (links[y + 1, x, 2 + k] + links[y + 1, x + 1, 2 + k]) / 2


@ti.kernel
def descend(
    diagonal: Channels,
    inverse: Channels,
    links: Channels,
    right: Channels,
    motion: Channels,
    coarse_right: Channels,
):
    """A sweep from rest, one colour of a chessboard and then the other; what is left, in 2 x 2 pixels.

    Of the other colour nothing is left.
    """
    height, width = motion.shape[0] - BEFORE - AFTER, motion.shape[1] - BEFORE - AFTER
    for colour in ti.static((0, 1)):
        for piece in range(height * pieces(width)):
            row, first = piece // pieces(width) + 1, piece % pieces(width) * PIECE + 1
            relax(inverse, links, right, row, first, colour, motion, colour == 0)
    half = coarse_right.shape[1] - BEFORE - AFTER
    for piece in range((coarse_right.shape[0] - BEFORE - AFTER) * pieces(half)):
        row, first = piece // pieces(half) + 1, piece % pieces(half) * PIECE + 1
        for column in range(first, ti.min(first + PIECE, half + 1)):
            left = ti.Vector([ti.f32(0.0), ti.f32(0.0)])
            for k in ti.static(range(2)):
                y, x = 2 * row - 1 + k, 2 * column - 1 + k
                left += pair(right, y, x) - applied(diagonal, links, motion, y, x)
            coarse_right[row, column, 0], coarse_right[row, column, 1] = left[0], left[1]


@ti.kernel
def ascend(inverse: Channels, links: Channels, right: Channels, coarse_motion: Channels, motion: Channels):
    """Add the coarse motion; a sweep in the order that mirrors the one of `descend`.

    It is added to the colour that comes last: the other one's motion follows from its neighbours' alone.
    """
    height, width = motion.shape[0] - BEFORE - AFTER, motion.shape[1] - BEFORE - AFTER
    for piece in range(height * pieces(width)):
        row, first = piece // pieces(width) + 1, piece % pieces(width) * PIECE + 1
        start = first + (row + first) % 2
        for step in range((ti.min(first + PIECE, width + 1) - start + 1) // 2):
            column = start + 2 * step
            for k in ti.static(range(2)):
                motion[row, column, k] += coarse_motion[(row + 1) // 2, (column + 1) // 2, k]
    for colour in ti.static((1, 0)):
        for piece in range(height * pieces(width)):
            row, first = piece // pieces(width) + 1, piece % pieces(width) * PIECE + 1
            relax(inverse, links, right, row, first, colour, motion, False)


@ti.kernel
def sweep(inverse: Channels, links: Channels, right: Channels, motion: Channels):
    """Sweeps and back in the mirrored order: for the coarsest grid, whose rows are one piece."""
    height = motion.shape[0] - BEFORE - AFTER
    for colour in ti.static((0, 1, 0, 1, 0, 1, 1, 0, 1, 0, 1, 0)):
        for row in range(1, height + 1):
            relax(inverse, links, right, row, 1, colour, motion, False)


@ti.kernel
def apply(diagonal: Channels, links: Channels, motion: Channels, left: Channels, sums: Sums):
    """The left-hand side, and its product with the motion in parts."""
    width = motion.shape[1] - BEFORE - AFTER
    for piece in range(sums.shape[0]):
        row, first = piece // pieces(width) + 1, piece % pieces(width) * PIECE + 1
        total = ti.f64(0.0)
        for column in range(first, ti.min(first + PIECE, width + 1)):
            result = applied(diagonal, links, motion, row, column)
            left[row, column, 0], left[row, column, 1] = result[0], result[1]
            total += result.dot(pair(motion, row, column))
        sums[piece] = total


@ti.kernel
def product(one: Channels, other: Channels, sums: Sums):
    """Inner product of two fields, in parts."""
    width = one.shape[1] - BEFORE - AFTER
    for piece in range(sums.shape[0]):
        row, first = piece // pieces(width) + 1, piece % pieces(width) * PIECE + 1
        total = ti.f64(0.0)
        for column in range(first, ti.min(first + PIECE, width + 1)):
            total += pair(one, row, column).dot(pair(other, row, column))
        sums[piece] = total


@ti.kernel
def turn(motion: Channels, share: ti.f32, direction: Channels):
    """The next direction: `motion`, and a share of the former direction."""
    width = motion.shape[1] - BEFORE - AFTER
    for piece in range((motion.shape[0] - BEFORE - AFTER) * pieces(width)):
        row, first = piece // pieces(width) + 1, piece % pieces(width) * PIECE + 1
        for column in range(first, ti.min(first + PIECE, width + 1)):
            for k in ti.static(range(2)):
                direction[row, column, k] = motion[row, column, k] + share * direction[row, column, k]


@ti.kernel
def step_along(
    direction: Channels,
    change: Channels,
    step: ti.f32,
    solution: Channels,
    right: Channels,
    sums: Sums,
):
    """A step of the solution, what it leaves of the right-hand side, and the square of that in parts.

    `change` is the left-hand side of `direction`.
    """
    width = right.shape[1] - BEFORE - AFTER
    for piece in range(sums.shape[0]):
        row, first = piece // pieces(width) + 1, piece % pieces(width) * PIECE + 1
        total = ti.f64(0.0)
        for column in range(first, ti.min(first + PIECE, width + 1)):
            for k in ti.static(range(2)):
                solution[row, column, k] += step * direction[row, column, k]
                left = right[row, column, k] - step * change[row, column, k]
                right[row, column, k] = left
                total += left * left
        sums[piece] = total
