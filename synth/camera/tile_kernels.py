# type: ignore  # taichi reads annotations and operators in its own way
"""Taichi kernels that sort micro-grains into tiles. Import only after `synth.devices.start_taichi`.

The grains are cut into as many parts as `count` and `start` have rows. One thread does a part from its first
grain to its last, so the order within a tile does not depend on the threads.
"""

import taichi as ti

from synth.camera import projection_kernels as projection
from synth.camera.cover_kernels import quotient, remainder
from synth.camera.share_kernels import SHARES

_f64 = ti.types.ndarray(dtype=ti.f64, ndim=1)
_f32_table = ti.types.ndarray(dtype=ti.f32, ndim=2)
_i32 = ti.types.ndarray(dtype=ti.i32, ndim=1)
_i32_table = ti.types.ndarray(dtype=ti.i32, ndim=2)
_u8 = ti.types.ndarray(dtype=ti.u8, ndim=1)

STEP = 2.0**-14
"""Samples; places are rounded to this, so that they are the same wherever a tile begins."""
NONE, SEVERAL = -1, -2
"""Instead of the tile that a grain touches."""


@ti.func
def _in_samples(view, x, z, diameter, sampling, margin):
    """Place from the margin's first sample, and radius, in samples."""
    at = projection.to_image(view, x, z)
    radius = 0.5 * diameter * view[0]
    if view[5] != 0.0:
        radius *= projection.magnification(view, x, z)
    column, row = (at[0] + margin + 0.5) * sampling - 0.5, (at[1] + margin + 0.5) * sampling - 0.5
    return ti.Vector([column, row, radius * sampling])


@ti.func
def _tiles_around(at, sampling, tile, columns, rows):
    """First and last column, first and last row of the tiles touched; none if a last is before the first."""
    per_side, reach = 1.0 / (tile * sampling), at[2] + 1.0
    low_i = ti.max(int(ti.floor((at[0] - reach) * per_side)), 0)
    low_j = ti.max(int(ti.floor((at[1] - reach) * per_side)), 0)
    high_i = ti.min(int(ti.floor((at[0] + reach) * per_side)), columns - 1)
    high_j = ti.min(int(ti.floor((at[1] + reach) * per_side)), rows - 1)
    return ti.Vector([low_i, high_i, low_j, high_j])


@ti.kernel
def find_tiles(
    x: _f64,
    z: _f64,
    diameter: _f64,
    drawn: _u8,
    view: projection.numbers,
    sampling: ti.template(),
    margin: ti.i32,
    tile: ti.template(),
    columns: ti.i32,
    rows: ti.i32,
    touched: _i32,
):
    """Tile that each grain touches, `SEVERAL`, or `NONE` for grains not in view or not to be drawn.

    Without a branch: which grains are drawn cannot be foreseen.
    """
    for g in range(x.shape[0]):
        at = _in_samples(view, x[g], z[g], diameter[g], sampling, margin)
        box = _tiles_around(at, sampling, tile, columns, rows)
        shown = (ti.cast(box[0] <= box[1], ti.u8) & ti.cast(box[2] <= box[3], ti.u8)) & drawn[g]
        only = ti.cast(box[0] == box[1], ti.u8) & ti.cast(box[2] == box[3], ti.u8)
        found = ti.select(only == 1, box[2] * columns + box[0], SEVERAL)
        touched[g] = ti.select(shown == 1, found, NONE)


@ti.kernel
def count_in_tiles(
    x: _f64,
    z: _f64,
    diameter: _f64,
    touched: _i32,
    view: projection.numbers,
    sampling: ti.template(),
    margin: ti.i32,
    tile: ti.template(),
    columns: ti.i32,
    rows: ti.i32,
    count: _i32_table,
    drawn: _i32,
):
    """Count every part's grains in every tile, and list those in one in `drawn`, from the part's first on.

    The last column of `count` becomes the length of the part's list, the one before it is scratch.
    """
    size = (x.shape[0] + count.shape[0] - 1) // count.shape[0]
    for share in range(count.shape[0] * SHARES):
        if share % SHARES != 0:
            continue
        part, last = share // SHARES, count.shape[1] - 1
        n = part * size
        for g in range(part * size, ti.min((part + 1) * size, x.shape[0])):
            only = touched[g]
            drawn[n] = g  # the next one writes over it, unless it is drawn
            n += ti.cast(only != NONE, ti.i32)
            if only == SEVERAL:
                at = _in_samples(view, x[g], z[g], diameter[g], sampling, margin)
                box = _tiles_around(at, sampling, tile, columns, rows)
                for j in range(box[2], box[3] + 1):
                    for i in range(box[0], box[1] + 1):
                        count[part, j * columns + i] = count[part, j * columns + i] + 1
            # No `+=`, which is atomic: nobody else writes a part's counts.
            column = ti.select(only >= 0, only, last - 1)
            count[part, column] = count[part, column] + 1
        count[part, last] = n - part * size


@ti.kernel
def sort_into_tiles(
    x: _f64,
    z: _f64,
    diameter: _f64,
    depth: _i32,
    touched: _i32,
    drawn: _i32,
    drawn_count: _i32,
    view: projection.numbers,
    sampling: ti.template(),
    margin: ti.i32,
    tile: ti.template(),
    columns: ti.i32,
    rows: ti.i32,
    index_bits: ti.i32,
    start: _i32_table,
    place: _f32_table,
    key: _i32,
    grain: _i32,
):
    """Write every part's grains where its share of each tile starts; `start` is used up."""
    size = (x.shape[0] + start.shape[0] - 1) // start.shape[0]
    for share in range(start.shape[0] * SHARES):
        if share % SHARES != 0:
            continue
        part = share // SHARES
        for n in range(part * size, part * size + drawn_count[part]):
            g = drawn[n]
            only = touched[g]
            at = _in_samples(view, x[g], z[g], diameter[g], sampling, margin)
            low_i, low_j = remainder(only, columns), quotient(only, columns)
            high_i, high_j = low_i, low_j
            if only == SEVERAL:
                box = _tiles_around(at, sampling, tile, columns, rows)
                low_i, high_i, low_j, high_j = box[0], box[1], box[2], box[3]
            for j in range(low_j, high_j + 1):
                for i in range(low_i, high_i + 1):
                    k = start[part, j * columns + i]
                    start[part, j * columns + i] = k + 1
                    off_x, off_y = at[0] - i * tile * sampling, at[1] - j * tile * sampling
                    place[k, 0] = ti.cast(_whole_steps(off_x) * STEP, ti.f32)
                    place[k, 1] = ti.cast(_whole_steps(off_y) * STEP, ti.f32)
                    place[k, 2] = ti.cast(at[2], ti.f32)
                    key[k] = ((depth[g] >> index_bits) << index_bits) | k
                    grain[k] = g


@ti.func
def _whole_steps(length):
    """Nearest whole number of steps, halves away from zero as `ti.round` has it, without its call."""
    steps = length * ti.static(1.0 / STEP)
    whole = ti.floor(ti.abs(steps) + 0.5)
    return ti.select(steps < 0.0, -whole, whole)
