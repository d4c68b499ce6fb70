# type: ignore  # taichi reads annotations and operators in its own way
"""Taichi kernels of the true motion. Import this module only after `synth.devices.start_taichi`.

Coordinates and buffers as in `synth.camera.kernels`.
"""

import taichi as ti

from synth.camera.kernels import IMPLEMENT, NOTHING

_f64 = ti.types.ndarray(dtype=ti.f64)
_f32 = ti.types.ndarray(dtype=ti.f32)
_i32 = ti.types.ndarray(dtype=ti.i32)
_u8 = ti.types.ndarray(dtype=ti.u8)
wheel_vector = ti.types.vector(6, ti.f64)
"""The wheel's argument of `find_mixed`."""


@ti.kernel
def fill_voids(
    centres: _i32,
    soil: _u8,
    samples: _i32,
    by_depth: _i32,
    x: _f64,
    y: _f64,
    radius: _f64,
    sampling: ti.i32,
    margin: ti.i32,
    reach: ti.f64,
    filled: _i32,
):
    """Depth at every pixel centre; in a soil's void, that of the visible grain whose rim is nearest.

    Rings of samples around the pixel are searched outwards until none can be nearer, or `reach` px.
    """
    for j, i in ti.ndrange(centres.shape[0], centres.shape[1]):
        filled[j, i] = centres[j, i]
        if centres[j, i] == NOTHING and soil[j, i] == 1:
            corner_j, corner_i = (j + margin) * sampling, (i + margin) * sampling
            nearest = reach
            ring = 0
            while ring < nearest * sampling and ring <= margin * sampling:
                top, left = corner_j - ring, corner_i - ring
                size = sampling + 2 * ring
                for n in range(size):
                    for side in ti.static(range(4)):
                        a, b = top, left
                        if ti.static(side == 0):
                            b += n
                        elif ti.static(side == 1):
                            a, b = a + size - 1, b + n
                        elif ti.static(side == 2):
                            a += n
                        else:
                            a, b = a + n, b + size - 1
                        depth = samples[a, b]
                        if depth != NOTHING and depth != IMPLEMENT and depth != filled[j, i]:
                            g = by_depth[depth]
                            gap = ti.sqrt((i - x[g]) ** 2 + (j - y[g]) ** 2) - radius[g]
                            if gap < nearest:
                                nearest = gap
                                filled[j, i] = depth
                ring += 1


@ti.func
def _rigid(off_x, off_y, move_x, move_y, cosine_less_one, sine):
    """Displacement of a point of a rigid body at an offset from the body's centre."""
    return ti.Vector(
        [move_x + cosine_less_one * off_x - sine * off_y, move_y + sine * off_x + cosine_less_one * off_y]
    )


@ti.kernel
def grain_motion(
    filled: _i32,
    by_depth: _i32,
    x: _f64,
    y: _f64,
    angle: _f64,
    next_x: _f64,
    next_y: _f64,
    next_angle: _f64,
    next_alive: _u8,
    strain: _f32,
    particle: _i32,
    u: _f32,
    v: _f32,
    rotation: _f32,
    pixel_strain: _f32,
    pixel_particle: _i32,
):
    """Motion of the grain at every pixel centre.

    Pixels without a grain, or with one that is lost by the next frame, keep what they hold.
    """
    for j, i in ti.ndrange(filled.shape[0], filled.shape[1]):
        if filled[j, i] != NOTHING and filled[j, i] != IMPLEMENT:
            g = by_depth[filled[j, i]]
            pixel_particle[j, i] = particle[g]
            if next_alive[g] == 1:
                turn = next_angle[g] - angle[g]
                moved = _rigid(
                    i - x[g],
                    j - y[g],
                    next_x[g] - x[g],
                    next_y[g] - y[g],
                    -2.0 * ti.sin(0.5 * turn) ** 2,
                    ti.sin(turn),
                )
                u[j, i], v[j, i] = ti.cast(moved[0], ti.f32), ti.cast(moved[1], ti.f32)
                rotation[j, i] = ti.cast(turn, ti.f32)
                pixel_strain[j, i] = strain[g]


@ti.func
def _sample_motion(
    i,
    j,
    a,
    b,
    samples: ti.template(),
    by_depth: ti.template(),
    x: ti.template(),
    y: ti.template(),
    motion: ti.template(),
    wheel,
    sampling,
    margin,
):
    """Motion at sample (a, b) of pixel (i, j), and whether there is one (third component)."""
    depth = samples[(j + margin) * sampling + b, (i + margin) * sampling + a]
    at_x, at_y = i + (a + 0.5) / sampling - 0.5, j + (b + 0.5) / sampling - 0.5
    result = ti.Vector([0.0, 0.0, 0.0])
    if depth == IMPLEMENT:
        moved = _rigid(at_x - wheel[0], at_y - wheel[1], wheel[2], wheel[3], wheel[4], wheel[5])
        result = ti.Vector([moved[0], moved[1], 1.0])
    elif depth != NOTHING:
        g = by_depth[depth]
        moved = _rigid(at_x - x[g], at_y - y[g], motion[g, 0], motion[g, 1], motion[g, 2], motion[g, 3])
        result = ti.Vector([moved[0], moved[1], motion[g, 4]])
    return result


@ti.kernel
def rigid_motions(
    x: _f64, y: _f64, angle: _f64, next_x: _f64, next_y: _f64, next_angle: _f64, next_alive: _u8, motion: _f32
):
    """Displacement of every grain, cos - 1 and sin of its turn, and 1 unless it is lost by the next frame."""
    for g in range(x.shape[0]):
        turn = next_angle[g] - angle[g]
        motion[g, 0] = ti.cast(next_x[g] - x[g], ti.f32)
        motion[g, 1] = ti.cast(next_y[g] - y[g], ti.f32)
        motion[g, 2] = ti.cast(-2.0 * ti.sin(0.5 * turn) ** 2, ti.f32)
        motion[g, 3] = ti.cast(ti.sin(turn), ti.f32)
        motion[g, 4] = ti.cast(next_alive[g], ti.f32)


@ti.kernel
def find_mixed(
    samples: _i32,
    by_depth: _i32,
    x: _f64,
    y: _f64,
    motion: _f32,
    wheel: wheel_vector,
    sampling: ti.i32,
    margin: ti.i32,
    limit: ti.f64,
    mixed: _u8,
):
    """Pixels with two samples whose motions are more than `limit` px apart.

    `motion` is that of `rigid_motions`; `wheel` holds the axle and its displacement, cos - 1 and
    sin of its turn.
    """
    for j, i in mixed:
        low, high = ti.Vector([1e30, 1e30]), ti.Vector([-1e30, -1e30])
        for b in range(sampling):
            row, column = (j + margin) * sampling + b, (i + margin) * sampling
            for a in range(sampling):
                # A rigid body's motion is linear along a row: only the ends of what it covers can be extreme.
                depth = samples[row, column + a]
                if (
                    a == 0
                    or a == sampling - 1
                    or depth != samples[row, column + a - 1]
                    or depth != samples[row, column + a + 1]
                ):
                    found = _sample_motion(
                        i, j, a, b, samples, by_depth, x, y, motion, wheel, sampling, margin
                    )
                    if found[2] > 0.0:
                        low, high = ti.min(low, found[:2]), ti.max(high, found[:2])
        span = high - low
        mixed[j, i] = ti.u8(0)
        if span.max() > limit:
            mixed[j, i] = ti.u8(1)
        elif span.min() >= 0.0 and span.norm() > limit:
            # Only here the box around the motions does not decide: compare every two samples.
            for b, a, d, c in ti.ndrange(sampling, sampling, sampling, sampling):
                one = _sample_motion(i, j, a, b, samples, by_depth, x, y, motion, wheel, sampling, margin)
                two = _sample_motion(i, j, c, d, samples, by_depth, x, y, motion, wheel, sampling, margin)
                if one[2] * two[2] > 0.0 and (one[:2] - two[:2]).norm() > limit:
                    mixed[j, i] = ti.u8(1)


@ti.kernel
def find_jumps(u: _f32, v: _f32, implement: _u8, limit: ti.f32, jump: _f32):
    """Largest difference of motion to a 4-neighbour beyond a discontinuity; -1 where there is none.

    A discontinuity lies between two neighbours whose motions differ by more than `limit` px, or of which
    exactly one is the implement. Neighbours without truth do not count.
    """
    for j, i in ti.ndrange(u.shape[0], u.shape[1]):
        largest = ti.f32(-1.0)
        for side in ti.static(range(4)):
            a, b = j, i
            if ti.static(side == 0):
                a -= 1
            elif ti.static(side == 1):
                a += 1
            elif ti.static(side == 2):
                b -= 1
            else:
                b += 1
            if 0 <= a < u.shape[0] and 0 <= b < u.shape[1]:
                apart = ti.sqrt((u[j, i] - u[a, b]) ** 2 + (v[j, i] - v[a, b]) ** 2)
                # NaN, where either has no truth, fails both comparisons.
                if apart > limit or (apart >= 0.0 and implement[j, i] != implement[a, b]):
                    largest = ti.max(largest, apart)
        jump[j, i] = largest


@ti.kernel
def nearest_in_column(jump: _f32, row: _i32):
    """Row of the nearest marked pixel (jump >= 0) in the same column, the upper of two; -1 without any."""
    height = jump.shape[0]
    for i in range(jump.shape[1]):
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
def nearest_in_picture(row: _i32, jump: _f32, stack: _i32, start: _f64, distance: _f32, nearest_jump: _f32):
    """Exact distance to the nearest marked pixel, and the jump there, by lower envelopes of parabolas.

    After Felzenszwalb and Huttenlocher, Theory of Computing 8, 2012. `stack` and `start` are scratch.
    """
    width = row.shape[1]
    for j in range(row.shape[0]):
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
                square = ti.cast((found - j) ** 2 + (other - i) ** 2, ti.f64)
                distance[j, i] = ti.cast(ti.sqrt(square), ti.f32)
                nearest_jump[j, i] = jump[found, other]
