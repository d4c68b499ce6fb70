# type: ignore  # taichi reads annotations and operators in its own way
"""Taichi kernels of grains that lie wholly behind another. Import only after `synth.devices.start_taichi`."""

import taichi as ti

SLACK = 1e-3
"""px; a grain that hides another reaches at least as much further: more than rounding can do."""

_f64 = ti.types.ndarray(dtype=ti.f64, ndim=1)
_u8 = ti.types.ndarray(dtype=ti.u8, ndim=1)
_i64 = ti.types.ndarray(dtype=ti.i64, ndim=1)
_i32 = ti.types.ndarray(dtype=ti.i32, ndim=1)
grid_vector = ti.types.vector(3, ti.f64)
"""Left and bottom of cells, and cells in a metre."""
_FINEST = 2.0**30
"""Steps in which room is counted."""


@ti.kernel
def find_hiders(
    x: _f64,
    z: _f64,
    diameter: _f64,
    depth: _i32,
    order: _i32,
    first: _i32,
    grid: grid_vector,
    columns: ti.i32,
    best: _i64,
):
    """For every grain, the one in front that it could move furthest behind without coming out, or -1.

    The lower 32 bits of `best` are the grain, those above the room there is, as a share of the front grain:
    the largest is the same in whatever order they are found. `order` holds the grains cell by cell, `first`
    each cell's first.
    """
    rows = (first.shape[0] - 1) // columns
    for h in range(x.shape[0]):
        radius = 0.5 * diameter[h]
        low_i = ti.max(ti.cast((x[h] - radius - grid[0]) * grid[2], ti.i32), 0)
        high_i = ti.min(ti.cast((x[h] + radius - grid[0]) * grid[2], ti.i32), columns - 1)
        low_j = ti.max(ti.cast((z[h] - radius - grid[1]) * grid[2], ti.i32), 0)
        high_j = ti.min(ti.cast((z[h] + radius - grid[1]) * grid[2], ti.i32), rows - 1)
        for j in range(low_j, high_j + 1):
            for n in range(first[j * columns + low_i], first[j * columns + high_i + 1]):
                g = order[n]
                less = radius - 0.5 * diameter[g]
                off_x, off_z = x[g] - x[h], z[g] - z[h]
                square = off_x * off_x + off_z * off_z
                if depth[h] < depth[g] and less > 0.0 and square < less * less:
                    room = ti.cast((less - ti.sqrt(square)) / radius * _FINEST, ti.i64)
                    ti.atomic_max(best[g], (room << 32) | ti.cast(h, ti.i64))


@ti.kernel
def leave_out_hidden(
    x: _f64,
    z: _f64,
    diameter: _f64,
    depth: _i32,
    alive: _u8,
    grain: _i32,
    hider: _i32,
    slack: ti.f64,
    index_bits: ti.i32,
    shown: _u8,
):
    """Clear those grains' marks that lie wholly behind their hider, `slack` (m) from its rim.

    Without a branch: which ones still do cannot be foreseen.
    """
    for n in range(grain.shape[0]):
        g, h = grain[n], hider[n]
        off_x, off_z = x[g] - x[h], z[g] - z[h]
        room = ti.max(0.5 * (diameter[h] - diameter[g]) - slack, 0.0)
        inside = ti.cast(off_x * off_x + off_z * off_z < room * room, ti.u8)
        in_front = ti.cast(depth[h] >> index_bits < depth[g] >> index_bits, ti.u8)
        shown[g] = alive[g] & (ti.u8(1) - (inside & in_front & alive[h]))
