# type: ignore  # taichi reads annotations and operators in its own way
"""Taichi kernels of the true motion. Import this module only after `synth.devices.start_taichi`.

Coordinates and buffers as in `synth.camera.cover_kernels`.
"""

import taichi as ti

from synth.camera import projection_kernels as projection
from synth.camera.cover_kernels import IMPLEMENT, NOTHING, remainder
from synth.camera.shares import SHARES

_f64 = ti.types.ndarray(dtype=ti.f64, ndim=1)
_f32 = ti.types.ndarray(dtype=ti.f32, ndim=1)
_f32_table = ti.types.ndarray(dtype=ti.f32, ndim=2)
_f32_fours = ti.types.ndarray(dtype=ti.types.vector(4, ti.f32), ndim=1)
_i32 = ti.types.ndarray(dtype=ti.i32, ndim=1)
_i32_samples = ti.types.ndarray(dtype=ti.i32, ndim=4)
_i32_table = ti.types.ndarray(dtype=ti.i32, ndim=2)
_u8 = ti.types.ndarray(dtype=ti.u8, ndim=1)
_u8_table = ti.types.ndarray(dtype=ti.u8, ndim=2)
body_vector = ti.types.vector(6, ti.f64)
"""The implement's argument of `find_mixed`."""
BLOCK = 8
"""px; side of the squares for which the spread of motions is bounded. A tile's is a multiple."""


@ti.kernel
def fill_voids(
    centres: _i32_table,
    soil: _u8_table,
    samples: _i32_samples,
    place: _f32_table,
    columns: ti.i32,
    tile: ti.template(),
    index_mask: ti.i32,
    sampling: ti.template(),
    margin: ti.i32,
    reach: ti.f32,
    filled: _i32_table,
):
    """Grain at every pixel centre, as its place among the tiled ones, or -1.

    In a soil's void it is the visible grain whose rim is nearest: rings of samples around the pixel are
    searched outwards until none can be nearer, or `reach` px.
    """
    for share in range(centres.shape[0] * SHARES):
        if share % SHARES != 0:
            continue
        j = share // SHARES
        for i in range(centres.shape[1]):
            found = -1
            if centres[j, i] != NOTHING and centres[j, i] != IMPLEMENT:
                found = centres[j, i] & index_mask
            if centres[j, i] == NOTHING and soil[j, i] == 1:
                found = _nearest_visible(
                    i + margin, j + margin, samples, place, columns, tile, index_mask, sampling, margin, reach
                )
            filled[j, i] = found


@ti.func
def _nearest_visible(
    i,
    j,
    samples: ti.template(),
    place: ti.template(),
    columns,
    tile: ti.template(),
    index_mask,
    sampling: ti.template(),
    margin,
    reach,
):
    """Place among the tiled grains of the nearest one seen around a pixel of the buffer; -1: none."""
    corner_j, corner_i = j * sampling, i * sampling
    middle = ti.f32(0.5 * (sampling - 1))
    at_x, at_y = ti.cast(corner_i, ti.f32) + middle, ti.cast(corner_j, ti.f32) + middle
    side = tile * sampling
    nearest = reach * ti.f32(1.0 * sampling)
    found, last, ring = -1, -1, 0
    while ti.cast(ring, ti.f32) < nearest and ring <= margin * sampling:
        top, left = corner_j - ring, corner_i - ring
        size = sampling + 2 * ring
        for n in range(size):
            for edge in ti.static(range(4)):
                a, b = top, left
                if ti.static(edge == 0):
                    b += n
                elif ti.static(edge == 1):
                    a, b = a + size - 1, b + n
                elif ti.static(edge == 2):
                    a += n
                else:
                    a, b = a + n, b + size - 1
                key = samples[a // sampling, b // sampling, a % sampling, b % sampling]
                if key != NOTHING and key != IMPLEMENT and key & index_mask != last:
                    k = last = key & index_mask
                    off_x = at_x - (place[k, 0] + ti.cast(b // side * side, ti.f32))
                    off_y = at_y - (place[k, 1] + ti.cast(a // side * side, ti.f32))
                    gap = ti.sqrt(off_x * off_x + off_y * off_y) - place[k, 2]
                    if gap < nearest:
                        nearest, found = gap, k
        ring += 1
    return found


@ti.func
def _spin(turn):
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
def _rigid(off_x, off_y, move_x, move_y, cosine_less_one, sine):
    """Displacement of a point of a rigid body at an offset from the body's centre."""
    return ti.Vector(
        [move_x + cosine_less_one * off_x - sine * off_y, move_y + sine * off_x + cosine_less_one * off_y]
    )


@ti.kernel
def rigid_motions(
    diameter: _f64,
    x: _f64,
    z: _f64,
    angle: _f64,
    next_x: _f64,
    next_z: _f64,
    next_angle: _f64,
    next_alive: _u8,
    view: projection.numbers,
    next_view: projection.numbers,
    motion: _f32_fours,
):
    """Displacement of every grain (px), its turn, and how far that moves its rim (px): -1 if it is lost."""
    for g in range(x.shape[0]):
        at = projection.to_image(view, x[g], z[g])
        to = projection.to_image(next_view, next_x[g], next_z[g])
        radius = 0.5 * diameter[g] * view[0]
        if view[5] != 0.0:
            radius *= projection.magnification(view, x[g], z[g])
        turn = ti.cast(angle[g] - next_angle[g], ti.f32)  # the picture's angles go the other way round
        # |cos - 1| + |sin| is not more than this.
        swing = ti.min(ti.abs(turn) * (1 + ti.f32(0.5) * ti.abs(turn)), ti.f32(3.0))
        rim = ti.select(next_alive[g] == 1, swing * ti.cast(radius, ti.f32), ti.f32(-1.0))
        motion[g] = ti.Vector([ti.cast(to[0] - at[0], ti.f32), ti.cast(to[1] - at[1], ti.f32), turn, rim])


@ti.kernel
def spread_in_blocks(
    first: _i32,
    columns: ti.i32,
    grain: _i32,
    place: _f32_table,
    motion: _f32_fours,
    tile: ti.template(),
    sampling: ti.template(),
    low: _f32_fours,
    high: _f32_fours,
    spread: _f32_table,
):
    """Bound on how far apart the motions are of all points of the grains that touch a block of pixels, px.

    Blocks go from the margin's first pixel. `low` and `high` are scratch, one entry a block.
    """
    per_block = ti.f32(1.0 / (BLOCK * sampling))
    across = tile // BLOCK
    for share in range((first.shape[0] - 1) * SHARES):
        if share % SHARES != 0:
            continue
        t = share // SHARES
        row, column = (t // columns) * across, (t % columns) * across
        for j in range(row, row + across):
            for i in range(column, column + across):
                low[j * spread.shape[1] + i] = ti.Vector([ti.f32(1e30)] * 4)
                high[j * spread.shape[1] + i] = ti.Vector([ti.f32(-1e30)] * 4)
        for k in range(first[t], first[t + 1]):
            moved = motion[grain[k]]
            if moved[3] >= 0:
                x, y, radius = place[k, 0], place[k, 1], place[k, 2]
                low_i = ti.max(ti.cast(ti.floor((x - radius) * per_block), ti.i32), 0)
                high_i = ti.min(ti.cast(ti.floor((x + radius) * per_block), ti.i32), across - 1)
                low_j = ti.max(ti.cast(ti.floor((y - radius) * per_block), ti.i32), 0)
                high_j = ti.min(ti.cast(ti.floor((y + radius) * per_block), ti.i32), across - 1)
                for j in range(row + low_j, row + high_j + 1):
                    for i in range(column + low_i, column + high_i + 1):
                        n = j * spread.shape[1] + i
                        low[n] = ti.min(low[n], moved)
                        high[n] = ti.max(high[n], moved)
        for j in range(row, row + across):
            for i in range(column, column + across):
                n = j * spread.shape[1] + i
                span = ti.max(high[n] - low[n], ti.f32(0.0))
                rim = ti.max(high[n][3], ti.f32(0.0))
                spread[j, i] = ti.sqrt(span[0] * span[0] + span[1] * span[1]) + 2 * rim


@ti.kernel
def grain_motion(
    filled: _i32_table,
    grain: _i32,
    x: _f64,
    z: _f64,
    motion: _f32_fours,
    view: projection.numbers,
    strain: _f32,
    particle: _i32,
    u: _f32_table,
    v: _f32_table,
    rotation: _f32_table,
    pixel_strain: _f32_table,
    pixel_particle: _i32_table,
):
    """Motion of the grain at every pixel centre; NaN, and particle -1, without one or where it is lost.

    `motion` is that of `rigid_motions`.
    """
    for share in range(filled.shape[0] * SHARES):
        if share % SHARES != 0:
            continue
        j = share // SHARES
        for i in range(filled.shape[1]):
            k = filled[j, i]
            nothing = ti.cast(ti.math.nan, ti.f32)
            moved_u, moved_v, turned, strained, near = nothing, nothing, nothing, nothing, -1
            if k >= 0:
                g = grain[k]
                near = particle[g]
                own = motion[g]
                if own[3] >= 0:
                    at = projection.to_image(view, x[g], z[g])
                    off_x, off_y = ti.cast(i - at[0], ti.f32), ti.cast(j - at[1], ti.f32)
                    spin = _spin(own[2])
                    moved = _rigid(off_x, off_y, own[0], own[1], spin[0], spin[1])
                    moved_u, moved_v = moved[0], moved[1]
                    turned, strained = own[2], strain[g]
            u[j, i], v[j, i], rotation[j, i], pixel_strain[j, i] = moved_u, moved_v, turned, strained
            pixel_particle[j, i] = near


@ti.func
def _sample_motion(
    a,
    b,
    samples: ti.template(),
    place: ti.template(),
    grain: ti.template(),
    motion: ti.template(),
    body,
    view,
    tile: ti.template(),
    index_mask,
    sampling: ti.template(),
    margin,
):
    """Motion at sample (row b, column a) of the buffer, and whether there is one (third component)."""
    key = samples[b // sampling, a // sampling, remainder(b, sampling), remainder(a, sampling)]
    result = ti.Vector([ti.f32(0.0), ti.f32(0.0), ti.f32(0.0)])
    if key == IMPLEMENT:
        at = projection.undistorted(
            view,
            (a + 0.5) / sampling - 0.5 - margin,
            (b + 0.5) / sampling - 0.5 - margin,
        )
        moved = _rigid(at[0] - body[0], at[1] - body[1], body[2], body[3], body[4], body[5])
        result = ti.Vector([ti.cast(moved[0], ti.f32), ti.cast(moved[1], ti.f32), ti.f32(1.0)])
    elif key != NOTHING:
        k = key & index_mask
        side, pixel = ti.static(tile * sampling), ti.f32(1.0 / sampling)
        off_x = (ti.cast(remainder(a, side), ti.f32) - place[k, 0]) * pixel
        off_y = (ti.cast(remainder(b, side), ti.f32) - place[k, 1]) * pixel
        own = motion[grain[k]]
        spin = _spin(own[2])
        moved = _rigid(off_x, off_y, own[0], own[1], spin[0], spin[1])
        result = ti.Vector([moved[0], moved[1], ti.select(own[3] >= 0, ti.f32(1.0), ti.f32(0.0))])
    return result


@ti.kernel
def find_mixed(
    samples: _i32_samples,
    place: _f32_table,
    grain: _i32,
    motion: _f32_fours,
    spread: _f32_table,
    outside: _f32_table,
    body: body_vector,
    view: projection.numbers,
    tile: ti.template(),
    index_mask: ti.i32,
    sampling: ti.template(),
    margin: ti.i32,
    limit: ti.f32,
    mixed: _u8_table,
):
    """Pixels with two samples whose motions are more than `limit` px apart.

    `motion` and `spread` are those of `rigid_motions` and `spread_in_blocks`, `outside` is the distance to
    the implement, px; `body` holds the implement's reference point and its displacement, cos - 1 and sin of
    its turn.
    """
    # Samples of a pixel are less than 3 px of an ideal lens apart: the implement's own motion does not mix.
    rigid = 3.0 * ti.sqrt(body[4] * body[4] + body[5] * body[5]) < limit
    for share in range(mixed.shape[0] * SHARES):
        if share % SHARES != 0:
            continue
        j = share // SHARES
        for i in range(mixed.shape[1]):
            row, column = (j + margin) * sampling, (i + margin) * sampling
            found = ti.u8(0)
            still = spread[(j + margin) // BLOCK, (i + margin) // BLOCK] < ti.f32(0.999) * limit
            if outside[j, i] < 2.0:
                still = rigid and _is_implement(row, column, samples, sampling)
            elif not still:
                still = _alike(row, column, samples, grain, motion, index_mask, sampling, limit)
            if not still:
                found = _differs(
                    row,
                    column,
                    samples,
                    place,
                    grain,
                    motion,
                    body,
                    view,
                    tile,
                    index_mask,
                    sampling,
                    margin,
                    limit,
                )
            mixed[j, i] = found


@ti.func
def _is_implement(row, column, samples: ti.template(), sampling: ti.template()):
    """Whether all samples of a pixel are the implement's."""
    whole = True
    for b in range(row, row + sampling):
        for a in range(column, column + sampling):
            whole = whole and samples[b // sampling, a // sampling, remainder(b, sampling), remainder(a, sampling)] == IMPLEMENT
    return whole


@ti.func
def _alike(
    row,
    column,
    samples: ti.template(),
    grain: ti.template(),
    motion: ti.template(),
    index_mask,
    sampling: ti.template(),
    limit,
):
    """Whether a pixel's grains move so much alike that none of its samples can differ: a quick look.

    The bound holds for whole grains, where no implement is in sight; it is kept a little off the limit for
    what rounding does.
    """
    low, high = ti.Vector([ti.f32(1e30)] * 2), ti.Vector([ti.f32(-1e30)] * 2)
    own, last = ti.f32(0.0), NOTHING
    for b in range(row, row + sampling):
        for a in range(column, column + sampling):
            key = samples[b // sampling, a // sampling, remainder(b, sampling), remainder(a, sampling)]
            if key != last and key != NOTHING:
                moved = motion[grain[key & index_mask]]
                if moved[3] >= 0:
                    centre = ti.Vector([moved[0], moved[1]])
                    low, high = ti.min(low, centre), ti.max(high, centre)
                    own = ti.max(own, moved[3])
            last = key
    span = ti.max(high - low, ti.f32(0.0))
    return span.norm() + 2 * own < ti.f32(0.999) * limit


@ti.func
def _differs(
    row,
    column,
    samples: ti.template(),
    place: ti.template(),
    grain: ti.template(),
    motion: ti.template(),
    body,
    view,
    tile: ti.template(),
    index_mask,
    sampling: ti.template(),
    margin,
    limit,
):
    """1 where two samples of a pixel move more than `limit` apart, else 0."""
    result = ti.u8(0)
    low, high = ti.Vector([ti.f32(1e30)] * 2), ti.Vector([ti.f32(-1e30)] * 2)
    for b in range(row, row + sampling):
        for a in range(column, column + sampling):
            found = _sample_motion(
                a, b, samples, place, grain, motion, body, view, tile, index_mask, sampling, margin
            )
            low = ti.min(low, ti.select(found[2] > 0.0, found[:2], low))
            high = ti.max(high, ti.select(found[2] > 0.0, found[:2], high))
    span = high - low
    if span.max() > limit:
        result = ti.u8(1)
    elif span.min() >= 0.0 and span.norm() > limit:
        # Only here the box around the motions does not decide: compare every two samples.
        for n in range(sampling**2):
            one = _sample_motion(
                column + n % sampling,
                row + n // sampling,
                samples,
                place,
                grain,
                motion,
                body,
                view,
                tile,
                index_mask,
                sampling,
                margin,
            )
            for m in range(n):
                two = _sample_motion(
                    column + m % sampling,
                    row + m // sampling,
                    samples,
                    place,
                    grain,
                    motion,
                    body,
                    view,
                    tile,
                    index_mask,
                    sampling,
                    margin,
                )
                if one[2] * two[2] > 0.0 and (one[:2] - two[:2]).norm() > limit:
                    result = ti.u8(1)
    return result
