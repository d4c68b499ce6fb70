# type: ignore  # taichi reads annotations and operators in its own way
"""Taichi kernels of the true motion. Import this module only after `synth.devices.start_taichi`.

Coordinates and buffers as in `synth.camera.cover_kernels`.

The motion of a tiled grain between two pictures is four numbers: displacement of its centre to the right
and downwards (px), its turn from x towards y (rad), and how far that moves its rim (px), or -1 if it is lost.
"""

import taichi as ti

from synth.camera import projection_kernels as projection
from synth.camera.share_kernels import ROWS, SHARES, TILES, dealt

_f64 = ti.types.ndarray(dtype=ti.f64, ndim=1)
_f64_pairs = ti.types.ndarray(dtype=ti.types.vector(2, ti.f64), ndim=2)
_f32 = ti.types.ndarray(dtype=ti.f32, ndim=1)
_f32_table = ti.types.ndarray(dtype=ti.f32, ndim=2)
_f32_pairs = ti.types.ndarray(dtype=ti.types.vector(2, ti.f32), ndim=2)
_f32_fours = ti.types.ndarray(dtype=ti.types.vector(4, ti.f32), ndim=1)
_f32_fours_table = ti.types.ndarray(dtype=ti.types.vector(4, ti.f32), ndim=2)
_i32 = ti.types.ndarray(dtype=ti.i32, ndim=1)
_i32_table = ti.types.ndarray(dtype=ti.i32, ndim=2)
_u8 = ti.types.ndarray(dtype=ti.u8, ndim=1)
_u8_table = ti.types.ndarray(dtype=ti.u8, ndim=2)
body_vector = ti.types.vector(6, ti.f64)
"""An implement's reference point (px of an ideal lens), its displacement, cos - 1 and sin of its turn."""
BLOCK = 4
"""px; side of the squares for which the spread of motions is bounded. A tile's is a multiple."""


@ti.func
def spin(turn):
    """Cos - 1 and sin; by their series, to 1e-14, where the angle is small, as it mostly is."""
    square = turn * turn
    half, sixth, twentieth, last = ti.f32(0.5), ti.f32(1 / 6), ti.f32(1 / 20), ti.f32(1 / 24)
    result = ti.Vector(
        [-square * (half - square * last), turn - turn * square * sixth * (1 - square * twentieth)]
    )
    if square > ti.f32(1e-4):
        sine = ti.sin(half * turn)
        result = ti.Vector([-2 * sine * sine, ti.sin(turn)])
    return result


@ti.func
def rigid_motion(off_x, off_y, move_x, move_y, cosine_less_one, sine):
    """Displacement of a point of a rigid body at an offset from the body's centre."""
    return ti.Vector(
        [move_x + cosine_less_one * off_x - sine * off_y, move_y + sine * off_x + cosine_less_one * off_y]
    )


@ti.kernel
def grain_motions(
    first: _i32,
    columns: ti.i32,
    grain: _i32,
    place: _f32_table,
    x: _f64,
    z: _f64,
    angle: _f64,
    next_x: _f64,
    next_z: _f64,
    next_angle: _f64,
    next_alive: _u8,
    view: projection.numbers,
    next_view: projection.numbers,
    tile: ti.template(),
    sampling: ti.template(),
    enough: ti.f32,
    motion: _f32_fours,
    low: _f32_fours_table,
    high: _f32_fours_table,
    spread: _f32_table,
):
    """Motion of every tiled grain, and how far apart those of a block's grains can be.

    `spread` is a bound, px, for all points of the grains that touch a block of pixels, counted from the
    margin's first one. Where that of a whole tile is less than `enough`, it serves all of its blocks. `low`
    and `high` are scratch, one entry a block.
    """
    across = tile // BLOCK
    for share in range((first.shape[0] - 1) * SHARES):
        if share % SHARES != 0:
            continue
        t = dealt(share // SHARES, first.shape[0] - 1, TILES)
        row, column = (t // columns) * across, (t % columns) * across
        least, most = ti.Vector([ti.f32(1e30)] * 4), ti.Vector([ti.f32(-1e30)] * 4)
        for k in range(first[t], first[t + 1]):
            g = grain[k]
            at = projection.to_image(view, x[g], z[g])
            to = projection.to_image(next_view, next_x[g], next_z[g])
            turn = ti.cast(angle[g] - next_angle[g], ti.f32)  # the picture's angles go the other way round
            # |cos - 1| + |sin| is not more than this.
            swing = ti.min(ti.abs(turn) * (1 + ti.f32(0.5) * ti.abs(turn)), ti.f32(3.0))
            there = next_alive[g] == 1
            rim = ti.select(there, swing * place[k, 2] * ti.f32(1.0 / sampling), ti.f32(-1.0))
            moved = ti.Vector([ti.cast(to[0] - at[0], ti.f32), ti.cast(to[1] - at[1], ti.f32), turn, rim])
            least = ti.select(there, ti.min(least, moved), least)
            most = ti.select(there, ti.max(most, moved), most)
            motion[k] = moved
        whole = _bound(least, most)
        for j, i in ti.ndrange((row, row + across), (column, column + across)):
            spread[j, i] = whole
        if whole >= enough:
            _spread_in_tile(t, row, column, first, place, motion, tile, sampling, low, high, spread)


@ti.func
def _spread_in_tile(
    t,
    row,
    column,
    first: ti.template(),
    place: ti.template(),
    motion: ti.template(),
    tile: ti.template(),
    sampling: ti.template(),
    low: ti.template(),
    high: ti.template(),
    spread: ti.template(),
):
    """Block by block, from a tile's first row and column of blocks."""
    across, per_block = ti.static(tile // BLOCK), ti.f32(1.0 / (BLOCK * sampling))
    for j, i in ti.ndrange((row, row + across), (column, column + across)):
        low[j, i], high[j, i] = ti.Vector([ti.f32(1e30)] * 4), ti.Vector([ti.f32(-1e30)] * 4)
    for k in range(first[t], first[t + 1]):
        moved = motion[k]
        if moved[3] >= 0:
            x, y, radius = place[k, 0], place[k, 1], place[k, 2]
            low_i = ti.max(ti.cast(ti.floor((x - radius) * per_block), ti.i32), 0)
            high_i = ti.min(ti.cast(ti.floor((x + radius) * per_block), ti.i32), across - 1)
            low_j = ti.max(ti.cast(ti.floor((y - radius) * per_block), ti.i32), 0)
            high_j = ti.min(ti.cast(ti.floor((y + radius) * per_block), ti.i32), across - 1)
            for j in range(row + low_j, row + high_j + 1):
                for i in range(column + low_i, column + high_i + 1):
                    low[j, i], high[j, i] = ti.min(low[j, i], moved), ti.max(high[j, i], moved)
    for j, i in ti.ndrange((row, row + across), (column, column + across)):
        spread[j, i] = _bound(low[j, i], high[j, i])


@ti.func
def _bound(low, high):
    """How far apart any points of grains move whose motions lie between two."""
    span = ti.max(high - low, ti.f32(0.0))
    return ti.sqrt(span[0] * span[0] + span[1] * span[1]) + 2 * ti.max(high[3], ti.f32(0.0))


@ti.func
def _lands_inside(i, j, u, v, width, height):
    """Whether a motion ends between the outermost pixel centres of the second picture; not for NaN."""
    x, y = ti.cast(i, ti.f32) + u, ti.cast(j, ti.f32) + v
    return x >= 0 and y >= 0 and x <= ti.cast(width - 1, ti.f32) and y <= ti.cast(height - 1, ti.f32)


@ti.kernel
def soil_motion(
    filled: _i32_table,
    off: _f32_pairs,
    motion: _f32_fours,
    strain: _f32,
    particle: _i32,
    u: _f32_table,
    v: _f32_table,
    rotation: _f32_table,
    pixel_strain: _f32_table,
    pixel_particle: _i32_table,
    valid: _u8_table,
):
    """Motion of the grain at every pixel centre; NaN, and particle -1, without one or where it is lost.

    `filled` and `off` are those of `void_kernels.fill_voids`.
    """
    for share in range(filled.shape[0] * SHARES):
        if share % SHARES != 0:
            continue
        j = dealt(share // SHARES, filled.shape[0], ROWS)
        for i in range(filled.shape[1]):
            k = filled[j, i]
            nothing = ti.cast(ti.math.nan, ti.f32)
            moved, turned, strained, near = ti.Vector([nothing, nothing]), nothing, nothing, -1
            if k >= 0:
                near = particle[k]
                own = motion[k]
                if own[3] >= 0:
                    turn = spin(own[2])
                    moved = rigid_motion(off[j, i][0], off[j, i][1], own[0], own[1], turn[0], turn[1])
                    turned, strained = own[2], strain[k]
            u[j, i], v[j, i], rotation[j, i], pixel_strain[j, i] = moved[0], moved[1], turned, strained
            pixel_particle[j, i] = near
            inside = _lands_inside(i, j, moved[0], moved[1], filled.shape[1], filled.shape[0])
            valid[j, i] = ti.cast(inside, ti.u8)


@ti.kernel
def implement_motion(
    implement: _u8_table,
    body: body_vector,
    turn: ti.f32,
    bent: _f64_pairs,
    view: projection.numbers,
    next_view: projection.numbers,
    u: _f32_table,
    v: _f32_table,
    rotation: _f32_table,
    strain: _f32_table,
    valid: _u8_table,
):
    """Motion of the implement at its pixels: rigid, plus `bent` (px of an ideal lens), (1, 1) without."""
    for share in range(implement.shape[0] * SHARES):
        if share % SHARES != 0:
            continue
        j = dealt(share // SHARES, implement.shape[0], 1)
        for i in range(implement.shape[1]):
            if implement[j, i] == 1:
                at = projection.undistorted(view, ti.cast(i, ti.f64), ti.cast(j, ti.f64))
                moved = rigid_motion(at[0] - body[0], at[1] - body[1], body[2], body[3], body[4], body[5])
                if bent.shape[0] > 1:
                    moved += bent[j, i]
                to = projection.distorted(next_view, at[0] + moved[0], at[1] + moved[1])
                u[j, i], v[j, i] = ti.cast(to[0] - i, ti.f32), ti.cast(to[1] - j, ti.f32)
                rotation[j, i], strain[j, i] = turn, ti.f32(0.0)
                inside = _lands_inside(i, j, u[j, i], v[j, i], u.shape[1], u.shape[0])
                valid[j, i] = ti.cast(inside, ti.u8)
