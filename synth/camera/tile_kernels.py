# type: ignore  # taichi reads annotations and operators in its own way
"""Taichi kernels that sort micro-grains into tiles. Import only after `synth.devices.start_taichi`.

The grains are cut into as many parts as `count` and `start` have rows. One thread does a part from its first
grain to its last, so the order within a tile does not depend on the threads.
"""

import taichi as ti

from synth.camera import projection_kernels as projection
from synth.camera.shares import SHARES

_f64 = ti.types.ndarray(dtype=ti.f64, ndim=1)
_f32_table = ti.types.ndarray(dtype=ti.f32, ndim=2)
_i32 = ti.types.ndarray(dtype=ti.i32, ndim=1)
_i32_table = ti.types.ndarray(dtype=ti.i32, ndim=2)
_u8 = ti.types.ndarray(dtype=ti.u8, ndim=1)

STEP = 2.0**-14
"""Samples; places are rounded to this, so that they are the same wherever a tile begins."""


@ti.func
def _touched(view, x, z, diameter, sampling, margin, tile, columns, rows):
    """Place in samples from the margin's first one, radius in samples, and the tiles touched.

    The tiles are first and last column, first and last row; none if the last is before the first.
    """
    at = projection.to_image(view, x, z)
    radius = 0.5 * diameter * view[0]
    if view[5] != 0.0:
        radius *= projection.magnification(view, x, z)
    column, row = (at[0] + margin + 0.5) * sampling - 0.5, (at[1] + margin + 0.5) * sampling - 0.5
    radius *= sampling
    per_side = 1.0 / (tile * sampling)
    reach = radius + 1.0
    low_i = ti.max(int(ti.floor((column - reach) * per_side)), 0)
    low_j = ti.max(int(ti.floor((row - reach) * per_side)), 0)
    high_i = ti.min(int(ti.floor((column + reach) * per_side)), columns - 1)
    high_j = ti.min(int(ti.floor((row + reach) * per_side)), rows - 1)
    return ti.Vector([column, row, radius]), ti.Vector([low_i, high_i, low_j, high_j])


@ti.kernel
def count_in_tiles(
    x: _f64,
    z: _f64,
    diameter: _f64,
    alive: _u8,
    view: projection.numbers,
    sampling: ti.template(),
    margin: ti.i32,
    tile: ti.template(),
    columns: ti.i32,
    count: _i32_table,
):
    """Count the grains of every part in every tile."""
    size = (x.shape[0] + count.shape[0] - 1) // count.shape[0]
    rows = count.shape[1] // columns
    for share in range(count.shape[0] * SHARES):
        if share % SHARES != 0:
            continue
        part = share // SHARES
        for g in range(part * size, ti.min((part + 1) * size, x.shape[0])):
            if alive[g] == 1:
                _, box = _touched(view, x[g], z[g], diameter[g], sampling, margin, tile, columns, rows)
                for j in range(box[2], box[3] + 1):
                    for i in range(box[0], box[1] + 1):
                        count[part, j * columns + i] += 1


@ti.kernel
def sort_into_tiles(
    x: _f64,
    z: _f64,
    diameter: _f64,
    alive: _u8,
    depth: _i32,
    view: projection.numbers,
    sampling: ti.template(),
    margin: ti.i32,
    tile: ti.template(),
    columns: ti.i32,
    start: _i32_table,
    index_bits: ti.i32,
    place: _f32_table,
    key: _i32,
    grain: _i32,
):
    """Write every part's grains where its share of each tile starts; `start` is used up."""
    size = (x.shape[0] + start.shape[0] - 1) // start.shape[0]
    rows = start.shape[1] // columns
    for share in range(start.shape[0] * SHARES):
        if share % SHARES != 0:
            continue
        part = share // SHARES
        for g in range(part * size, ti.min((part + 1) * size, x.shape[0])):
            if alive[g] == 1:
                at, box = _touched(view, x[g], z[g], diameter[g], sampling, margin, tile, columns, rows)
                for j in range(box[2], box[3] + 1):
                    for i in range(box[0], box[1] + 1):
                        k = start[part, j * columns + i]
                        start[part, j * columns + i] = k + 1
                        off_x, off_y = at[0] - i * tile * sampling, at[1] - j * tile * sampling
                        place[k, 0] = ti.cast(ti.round(off_x * ti.static(1.0 / STEP)) * STEP, ti.f32)
                        place[k, 1] = ti.cast(ti.round(off_y * ti.static(1.0 / STEP)) * STEP, ti.f32)
                        place[k, 2] = ti.cast(at[2], ti.f32)
                        key[k] = ((depth[g] >> index_bits) << index_bits) | k
                        grain[k] = g
