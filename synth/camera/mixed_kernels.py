# type: ignore  # taichi reads annotations and operators in its own way
"""Taichi kernels of pixels that hold several motions. Import only after `synth.devices.start_taichi`.

Coordinates and buffers as in `synth.camera.cover_kernels`, motions as in `synth.camera.motion_kernels`.
"""

import taichi as ti

from synth.camera import projection_kernels as projection
from synth.camera.cover_kernels import IMPLEMENT, NOTHING, remainder
from synth.camera.motion_kernels import BLOCK, body_vector, rigid_motion, spin
from synth.camera.share_kernels import ROWS, SHARES, dealt

_f32_table = ti.types.ndarray(dtype=ti.f32, ndim=2)
_f32_fours = ti.types.ndarray(dtype=ti.types.vector(4, ti.f32), ndim=1)
_i32_samples = ti.types.ndarray(dtype=ti.i32, ndim=4)
_u8_table = ti.types.ndarray(dtype=ti.u8, ndim=2)


@ti.kernel
def find_mixed(
    samples: _i32_samples,
    place: _f32_table,
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

    `motion` and `spread` are those of `motion_kernels.grain_motions`, `outside` is the distance to the
    implement, px, `body` that of `motion_kernels.body_vector`.
    """
    # Samples of a pixel are less than 3 px of an ideal lens apart: the implement's own motion does not mix.
    stiff = 3.0 * ti.sqrt(body[4] * body[4] + body[5] * body[5]) < limit
    for share in range(mixed.shape[0] * SHARES):
        if share % SHARES != 0:
            continue
        j = margin + dealt(share // SHARES, mixed.shape[0], ROWS)
        for i in range(margin, margin + mixed.shape[1]):
            still = spread[j // BLOCK, i // BLOCK] < ti.f32(0.999) * limit
            if outside[j - margin, i - margin] < 2.0:
                still = stiff and _is_implement(j, i, samples, sampling)
            elif not still:
                still = _alike(j, i, samples, motion, index_mask, sampling, limit)
            found = False
            if not still:
                found = _differs(
                    j, i, samples, place, motion, body, view, tile, index_mask, sampling, margin, limit
                )
            mixed[j - margin, i - margin] = ti.cast(found, ti.u8)


@ti.func
def _is_implement(j, i, samples: ti.template(), sampling: ti.template()):
    """Whether all samples of a pixel are the implement's."""
    whole = True
    for b in range(sampling):
        for a in range(sampling):
            whole = whole and samples[j, i, b, a] == IMPLEMENT
    return whole


@ti.func
def _alike(j, i, samples: ti.template(), motion: ti.template(), index_mask, sampling: ti.template(), limit):
    """Whether a pixel's grains move so much alike that none of its samples can differ: a quick look.

    The bound holds for whole grains, where no implement is in sight; it is kept a little off the limit for
    what rounding does.
    """
    low, high = ti.Vector([ti.f32(1e30)] * 2), ti.Vector([ti.f32(-1e30)] * 2)
    own, last = ti.f32(0.0), NOTHING
    for b in range(sampling):
        for a in range(sampling):
            key = samples[j, i, b, a]
            if key != last and key != NOTHING:
                moved = motion[key & index_mask]
                if moved[3] >= 0:
                    centre = ti.Vector([moved[0], moved[1]])
                    low, high = ti.min(low, centre), ti.max(high, centre)
                    own = ti.max(own, moved[3])
            last = key
    span = ti.max(high - low, ti.f32(0.0))
    return span.norm() + 2 * own < ti.f32(0.999) * limit


@ti.func
def _differs(
    j,
    i,
    samples: ti.template(),
    place: ti.template(),
    motion: ti.template(),
    body,
    view,
    tile: ti.template(),
    index_mask,
    sampling: ti.template(),
    margin,
    limit,
):
    """Whether two samples of a pixel move more than `limit` apart."""
    result = False
    low, high = ti.Vector([ti.f32(1e30)] * 2), ti.Vector([ti.f32(-1e30)] * 2)
    for b in range(sampling):
        for a in range(sampling):
            found = _sample_motion(
                j, i, b, a, samples, place, motion, body, view, tile, index_mask, sampling, margin
            )
            low = ti.min(low, ti.select(found[2] > 0.0, found[:2], low))
            high = ti.max(high, ti.select(found[2] > 0.0, found[:2], high))
    span = high - low
    if span.max() > limit:
        result = True
    elif span.min() >= 0.0 and span.norm() > limit:
        # Only here the box around the motions does not decide: compare every two samples.
        for n in range(sampling**2):
            b, a = n // sampling, n % sampling
            one = _sample_motion(
                j, i, b, a, samples, place, motion, body, view, tile, index_mask, sampling, margin
            )
            for m in range(n):
                b, a = m // sampling, m % sampling
                two = _sample_motion(
                    j, i, b, a, samples, place, motion, body, view, tile, index_mask, sampling, margin
                )
                if one[2] * two[2] > 0.0 and (one[:2] - two[:2]).norm() > limit:
                    result = True
    return result


@ti.func
def _sample_motion(
    j,
    i,
    b,
    a,
    samples: ti.template(),
    place: ti.template(),
    motion: ti.template(),
    body,
    view,
    tile: ti.template(),
    index_mask,
    sampling: ti.template(),
    margin,
):
    """Motion at a sample of the buffer, and whether there is one (third component)."""
    key = samples[j, i, b, a]
    result = ti.Vector([ti.f32(0.0), ti.f32(0.0), ti.f32(0.0)])
    if key == IMPLEMENT:
        x, y = (a + 0.5) / sampling - 0.5 + (i - margin), (b + 0.5) / sampling - 0.5 + (j - margin)
        at = projection.undistorted(view, x, y)
        moved = rigid_motion(at[0] - body[0], at[1] - body[1], body[2], body[3], body[4], body[5])
        result = ti.Vector([ti.cast(moved[0], ti.f32), ti.cast(moved[1], ti.f32), ti.f32(1.0)])
    elif key != NOTHING:
        k, pixel = key & index_mask, ti.f32(1.0 / sampling)
        own = motion[k]
        turn = spin(own[2])
        off_x = (ti.cast(remainder(i, tile) * sampling + a, ti.f32) - place[k, 0]) * pixel
        off_y = (ti.cast(remainder(j, tile) * sampling + b, ti.f32) - place[k, 1]) * pixel
        moved = rigid_motion(off_x, off_y, own[0], own[1], turn[0], turn[1])
        result = ti.Vector([moved[0], moved[1], ti.select(own[3] >= 0, ti.f32(1.0), ti.f32(0.0))])
    return result
