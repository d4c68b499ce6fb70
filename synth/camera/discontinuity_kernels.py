# type: ignore  # taichi reads annotations and operators in its own way
"""Taichi kernels of where motion breaks off. Import this module only after `synth.devices.start_taichi`.

Tables of a picture's pixels throughout, (H, W).
"""

import taichi as ti

from synth.camera.share_kernels import SHARES

_f64_table = ti.types.ndarray(dtype=ti.f64, ndim=2)
_f32_table = ti.types.ndarray(dtype=ti.f32, ndim=2)
_i32_table = ti.types.ndarray(dtype=ti.i32, ndim=2)
_u8_table = ti.types.ndarray(dtype=ti.u8, ndim=2)


@ti.kernel
def find_jumps(u: _f32_table, v: _f32_table, implement: _u8_table, limit: ti.f32, jump: _f32_table):
    """Largest difference of motion to a 4-neighbour beyond a discontinuity; -1 where there is none.

    A discontinuity lies between two neighbours whose motions differ by more than `limit` px, or of which
    exactly one is the implement. Neighbours without truth do not count.
    """
    for share in range(u.shape[0] * SHARES):
        if share % SHARES != 0:
            continue
        j = share // SHARES
        _jumps_in(j, u, v, implement, limit, jump)


@ti.func
def _jumps_in(j, u: ti.template(), v: ti.template(), implement: ti.template(), limit, jump: ti.template()):
    """Of one row. Beyond the picture's edge lies the pixel itself, which makes no jump."""
    above, below, last = ti.max(j - 1, 0), ti.min(j + 1, u.shape[0] - 1), u.shape[1] - 1
    left = ti.f32(-1.0)
    for i in range(u.shape[1]):
        right = _jump_between(j, i, j, ti.min(i + 1, last), u, v, implement, limit)
        largest = ti.max(left, right)
        largest = ti.max(largest, _jump_between(j, i, above, i, u, v, implement, limit))
        largest = ti.max(largest, _jump_between(j, i, below, i, u, v, implement, limit))
        jump[j, i] = ti.select(largest > 0.0, ti.sqrt(ti.max(largest, ti.f32(0.0))), largest)
        left = right


@ti.func
def _jump_between(j, i, a, b, u: ti.template(), v: ti.template(), implement: ti.template(), limit):
    """Square of the difference of motion between two neighbours, -1 without a discontinuity between them."""
    over, down = u[j, i] - u[a, b], v[j, i] - v[a, b]
    square = over * over + down * down
    # NaN, where either has no truth, fails both comparisons.
    beyond = (square > limit * limit) | ((square >= 0.0) & (implement[j, i] != implement[a, b]))
    return ti.select(beyond, square, ti.f32(-1.0))


@ti.kernel
def nearest_in_column(jump: _f32_table, row: _i32_table):
    """Row of the nearest marked pixel (jump >= 0) in the same column, the upper of two; -1 without any."""
    height = jump.shape[0]
    for share in range(jump.shape[1] * SHARES):
        if share % SHARES != 0:
            continue
        i = share // SHARES
        last = -1
        for j in range(height):
            if jump[j, i] >= 0.0:
                last = j
            row[j, i] = last
        last = -1
        for k in range(height):
            j = height - 1 - k
            if jump[j, i] >= 0.0:
                last = j
            if last >= 0 and (row[j, i] < 0 or last - j < j - row[j, i]):
                row[j, i] = last


@ti.kernel
def nearest_in_picture(
    row: _i32_table,
    jump: _f32_table,
    stack: _i32_table,
    start: _f64_table,
    distance: _f32_table,
    nearest_jump: _f32_table,
):
    """Distance to the nearest discontinuity, and the jump there: exact, by lower envelopes of parabolas.

    A discontinuity is half a pixel beyond the nearest marked pixel; without any, infinite and NaN.

    After Felzenszwalb and Huttenlocher, Theory of Computing 8, 2012. `stack` and `start` are scratch.
    """
    width = row.shape[1]
    for share in range(row.shape[0] * SHARES):
        if share % SHARES != 0:
            continue
        j = share // SHARES
        count = 0
        for i in range(width):
            if row[j, i] >= 0:
                height = ti.cast((row[j, i] - j) ** 2 + i * i, ti.f64)
                crossing = -1e30
                while count > 0:
                    other = stack[j, count - 1]
                    below = ti.cast((row[j, other] - j) ** 2 + other * other, ti.f64)
                    crossing = (height - below) / (2.0 * (i - other))
                    if crossing > start[j, count - 1]:
                        break
                    count -= 1
                    crossing = -1e30
                stack[j, count], start[j, count] = i, crossing
                count += 1
        k = 0
        for i in range(width):
            if count > 0:
                while k + 1 < count and start[j, k + 1] < i:
                    k += 1
                other = stack[j, k]
                found = row[j, other]
                square = ti.cast((found - j) ** 2 + (other - i) ** 2, ti.f32)
                distance[j, i] = ti.sqrt(square) + ti.f32(0.5)
                nearest_jump[j, i] = jump[found, other]
            else:
                distance[j, i] = ti.cast(ti.math.inf, ti.f32)
                nearest_jump[j, i] = ti.cast(ti.math.nan, ti.f32)
